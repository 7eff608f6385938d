#pragma once

#include <string>
#include <vector>

namespace brdfit {

/// How a parameter is spaced in searches and in the optimiser's coordinates.
enum class Scale {
    Linear,
    Log,      ///< roughness: x = log(p)
    Log1p,    ///< exponents from 0: x = log(1 + p)
    AboutOne, ///< fine about -1 and 1: x = sign(p) (asinh(100 (|p| - 1)) + asinh(100))
    Angle     ///< degrees, alike after 180: x in radians
};

/// A non-linear parameter of a lobe.
struct Parameter {
    std::string name;
    double lower = 0, upper = 1; ///< closed range
    double start = 0.5;          ///< a typical value
    Scale scale = Scale::Linear;
    /// Whether it is how wide the lobe is, a roughness or an exponent.
    bool width() const { return scale == Scale::Log || scale == Scale::Log1p; }
};

/// What a model is in a material.
enum class Kind {
    Lobe,           ///< a specular lobe g(wi, wo; theta)
    Diffuse,        ///< a diffuse shape
    DiffuseAndLobe, ///< names a diffuse shape that goes with the lobe model `lobe`
};

/// One model: everything the host knows of it. Its value and derivatives are in
/// kernels/models/NAME.cl, which defines (with '-' as '_')
///     enum { ..., NAME_PLANES }                          names of its planes, in capitals
///     NAME_prepare(geometry, real plane[])               fills them: quantities of the directions
///                                                        alone
///     real NAME(const real plane[], theta, real d[])     value, and derivative by each parameter
/// and, for a lobe, with theta in the anisotropic form (see kernels/terms/half_vectors.cl)
///     geometry NAME_sample(wo, theta, u1, u2)            wi drawn from two uniform numbers
///     real NAME_density(geometry, theta)                 its density by the solid angle of wi
/// and, where the two forms differ (see oriented),
///     real NAME_by_turn(geometry, theta)                 derivative of log g by the angle, in
///                                                        radians, by which the frame is turned
///                                                        about n
struct Model {
    std::string name;
    Kind kind = Kind::Lobe;
    std::string lobe;     ///< DiffuseAndLobe: the lobe model it is coupled with
    std::string shape;    ///< g, or the diffuse shape, for people
    std::string equation; ///< paper and equation
    /// Isotropic and anisotropic form; equal where the model has one form only.
    std::vector<Parameter> isotropic, anisotropic;
    /// Planes that NAME_prepare fills in the isotropic and the anisotropic form, NAME_PLANES of the
    /// kernel file: a program where they differ does not build.
    int isotropic_planes = 0, anisotropic_planes = 0;
    bool reciprocal = true;
    bool conserves_energy =
        false; ///< R <= 1 for every parameter in range, ks = f0 = 1 (Kind::Lobe)
    /// Name as a diffuse shape, in material files and --diffuse, where it is not `name`; such a
    /// model is an option of its lobe, not listed by itself.
    std::string diffuse_name;
    /// A variant of that model, which renderers use: chosen by name, not listed by itself.
    std::string variant_of;
    /// Whether its shape comes from a table that the lobe names (a diffuse shape: the first lobe)
    /// beside its parameters. Its functions then take `table` after theta; it is not fitted.
    bool table = false;
    /// Whether the last parameter of the anisotropic form is `orientation` (see oriented).
    bool turns = false;

    const std::vector<Parameter>& parameters(bool iso) const {
        return iso ? isotropic : anisotropic;
    }
    int planes(bool iso) const { return iso ? isotropic_planes : anisotropic_planes; }
    /// Whether theta[0] is f0, of which g is an affine function (Schlick's F).
    bool fresnel() const { return !isotropic.empty() && isotropic[0].name == "f0"; }
    /// Whether it stands for itself in lists and in `all`.
    bool listed() const { return diffuse_name.empty() && variant_of.empty(); }
    /// The name as an OpenCL C identifier.
    std::string identifier() const;
};

/// All models given by parameters, in the order they are listed (see Model::listed).
const std::vector<Model>& catalogue();
/// The models whose lobes name a table.
const std::vector<Model>& table_models();
/// The model with its tangent frame turned about n by one more parameter, `orientation`, degrees
/// from x towards y, in the anisotropic form: its planes are then those of the directions, which
/// are turned and prepared at each evaluation. nullptr where g is the same in every frame or the
/// model reads a table.
const Model* oriented(const Model& model);
/// The model of that name, with or without a table, or nullptr.
const Model* find_model(const std::string& name);
/// The model of that name. Throws UsageError listing the known names.
const Model& model_named(const std::string& name);
/// The diffuse shape of that name, or nullptr.
const Model* find_diffuse(const std::string& name);
/// The name of a diffuse shape in material files.
inline const std::string& diffuse_name_of(const Model& diffuse) {
    return diffuse.diffuse_name.empty() ? diffuse.name : diffuse.diffuse_name;
}

} // namespace brdfit
