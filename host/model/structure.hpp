#pragma once

#include "host/model/catalogue.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// What a program is specialised by: the models of a material, not their parameters.
struct Structure {
    const Model* diffuse = nullptr;
    std::vector<const Model*> lobes;
    bool isotropic = true; ///< form of every lobe

    /// For people and file names: "kurt" for any number of kurt lobes, "kurt+ward" for a mixture; a
    /// coupled diffuse shape stands for its lobe.
    std::string name() const;
    /// Whether the diffuse shape goes with the first lobe, whose f0 it has.
    bool coupled() const { return diffuse->kind == Kind::DiffuseAndLobe; }
    /// Whether a lobe's model reads a table (Model::table).
    bool has_tables() const;
    /// Whether the frame of a lobe is turned (Model::turns).
    bool turns() const;
    /// Unlike for structures that differ.
    std::string key() const;
};

/// A derivative a program computes: of basis function `basis` (0 diffuse, 1.. lobes) by parameter
/// `parameter` of the concatenated theta of all lobes.
struct DerivativeEntry {
    int basis, parameter;
};

/// How a structure's parameters, planes and derivatives are laid out in its program.
struct StructureLayout {
    std::vector<Parameter> parameters;    ///< of all lobes, concatenated
    std::vector<int> lobe_begin;          ///< first parameter of each lobe, then the count
    std::vector<DerivativeEntry> entries; ///< by lobe and parameter, then the diffuse shape's
    int basis = 1;                        ///< diffuse and lobes
    int planes = 0;                       ///< of the distinct models
};

/// The structure in the anisotropic form with every lobe's frame turned that can be (see oriented).
Structure turned(Structure structure);

StructureLayout layout_of(const Structure& structure);
/// Words from one set of parameters to the next where a program takes several (PARAMETERS there); 0
/// with tables: there is one set.
std::size_t parameter_stride(const Structure& structure);

/// A model of a structure with the first of its planes.
struct PlacedModel {
    const Model* model;
    int first_plane;
};
/// The distinct models of a structure, in the order of their planes: diffuse first.
std::vector<PlacedModel> placed_models(const Structure& structure);
/// Whether the planes of two structures are the same: of the same models, in any number.
bool same_planes(const Structure& a, const Structure& b);

} // namespace brdfit
