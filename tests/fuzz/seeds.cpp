// fuzz_seeds FOLDER writes what fuzzers begin with: small whole files to FOLDER/NAME/ for the
// fuzzer fuzz_NAME, and the words in them to FOLDER/NAME.dict.

#include "fit/runs/log.hpp"
#include "fit/runs/plan.hpp"
#include "fit/structures.hpp"
#include "host/device/kernels.hpp"
#include "host/files/json.hpp"
#include "host/files/npy.hpp"
#include "host/files/zip.hpp"
#include "host/model/catalogue.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/examples.hpp"
#include "tests/support/rgl.hpp"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>

#include <cctype>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

namespace {

using namespace brdfit;

std::string read_bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Seeds by the fuzzer's name.
class Seeds {
  public:
    void add(const std::string& fuzzer, const std::string& bytes) { all_[fuzzer].push_back(bytes); }
    /// Adds what write(path) writes.
    template <typename Write>
    void add_file(const std::string& fuzzer, const Write& write) {
        const std::string path = fuzz::folder() + "/seed";
        write(path);
        add(fuzzer, read_bytes(path));
        std::filesystem::remove(path);
    }
    void write(const std::filesystem::path& folder) const {
        for (const auto& [fuzzer, seeds] : all_) {
            std::filesystem::create_directories(folder / fuzzer);
            for (std::size_t i = 0; i < seeds.size(); ++i)
                std::ofstream(folder / fuzzer / fmt::format("{:03}", i), std::ios::binary)
                    << seeds[i];
            std::ofstream words(folder / (fuzzer + ".dict"));
            words << "# no dictionary may be empty\n";
            for (const std::string& word : words_of(seeds))
                words << '"' << word << "\"\n";
        }
    }

  private:
    static std::set<std::string> words_of(const std::vector<std::string>& seeds) {
        std::set<std::string> words;
        for (const std::string& seed : seeds) {
            std::string word;
            for (const char c : seed + '\0') {
                if (std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                    (c != 0 && std::string("_-.").find(c) != std::string::npos)) {
                    word += c;
                    continue;
                }
                if (word.size() > 2 && word.size() < 33 &&
                    std::isalpha(static_cast<unsigned char>(word[0])) != 0)
                    words.insert(word);
                word.clear();
            }
        }
        return words;
    }
    std::map<std::string, std::vector<std::string>> all_;
};

void add_measured(Seeds& seeds) {
    const std::string weighted =
        "# note\ntheta_i,phi_i,theta_o,phi_o,Y,weight\n+0.5,0,1.5707963,3,-1e-3,0\n";
    const float values[16] = {0, 0, 1, 0, 0, 1, 2, 1, 0, 0, 1, 1, 0, 0, 3, 0};
    const double wide_values[8] = {0, 0, 1, 0, 0, 1, 2, 1};
    const std::string npy =
        npy::header(2, 8) + std::string(reinterpret_cast<const char*>(values), sizeof values);
    const std::string wide =
        npy::header({1, 8}, "<f8") +
        std::string(reinterpret_cast<const char*>(wide_values), sizeof wide_values);
    const std::string merl = test::merl_header(90, 90, 180) + std::string(200, '\0');
    for (const auto& [fuzzer, bytes] : std::vector<std::pair<std::string, std::string>>{
             {"scattered", test::csv_example},
             {"scattered", weighted},
             {"astm", test::astm_example},
             {"cornell", test::cornell_example},
             {"npy", npy},
             {"npy", wide},
             {"npy", test::npy_example()},
             {"rgl", test::tensor_bytes(test::rgl_fields())},
             {"rgl", test::tensor_bytes(test::rgl_fields(3, pi, 2))},
             {"zemax", test::zemax_example},
             {"fred", test::fred_example},
             {"alta", test::alta_example},
             {"merl", merl}}) {
        seeds.add(fuzzer, bytes);
        seeds.add("measured", bytes);
    }
    for (const char* in : {"3 1\n#PARAM_IN ISOTROPIC_TV_TL_DPHI", "3 3\n#PARAM_IN RUSIN_TH_TD_PD",
                           "4 1\n#VS 2\n#PARAM_IN SPHERICAL_TL_PL_TV_PV",
                           "4 1\n#PARAM_IN RUSIN_TH_PH_TD_PD", "6 1\n#PARAM_IN CARTESIAN"})
        seeds.add("alta", std::string("#DIM ") + in + "\n0.1 0.2 0.3 0.4 0.5 0.6 0.7\n");
    // wi, wo, values, weights and channels of an archive.
    const auto array = [&](std::vector<std::size_t> shape) {
        std::size_t bytes = sizeof(float);
        for (const std::size_t side : shape)
            bytes *= side;
        return npy::header(shape, "<f4") +
               std::string(reinterpret_cast<const char*>(values), bytes);
    };
    const std::vector<std::string> arrays = {array({1, 3}), array({1, 3}), array({1, 2}),
                                             array({1}), npy::texts({"R", "470 nm"})};
    for (const std::size_t count : {3U, 4U, 5U}) {
        std::string bytes;
        for (std::size_t k = 0; k < count; ++k)
            bytes += arrays[k];
        seeds.add("npz", bytes);
        seeds.add_file("npz", [&](const std::string& path) {
            zip::Writer writer(path);
            const char* const names[] = {"wi", "wo", "values", "weights", "channels"};
            for (std::size_t k = 0; k < count; ++k)
                writer.add(std::string(names[k]) + ".npy", arrays[k], {});
            writer.commit();
        });
    }
    seeds.add("measured", "{}");
    seeds.add("utia", std::string(reinterpret_cast<const char*>(wide_values), sizeof wide_values));
    seeds.add("directions", test::npy_example());
    seeds.add("directions", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0.6,0,0.8\n0,0,1,0,0,-1\n");
}

void add_materials(Seeds& seeds) {
    seeds.add("material", test::material_example);
    for (const auto* models : {&catalogue(), &table_models()})
        for (const Model& model : *models)
            for (const bool isotropic : {true, false}) {
                Json json = {{"brdfit", 1},
                             {"channels", {"Y"}},
                             {"diffuse", {{"model", "lambert"}, {"kd", {0.5}}}},
                             {"lobes", Json::array()}};
                if (model.kind != Kind::Lobe)
                    json["diffuse"]["model"] = diffuse_name_of(model);
                if (model.kind == Kind::Lobe || !model.lobe.empty()) {
                    const Model& shape = model.lobe.empty() ? model : model_named(model.lobe);
                    Json lobe = {{"model", shape.name}, {"ks", {0.25}}};
                    for (const Parameter& p : shape.parameters(isotropic))
                        lobe[p.name] = (p.lower + p.upper) / 2;
                    if (shape.table)
                        lobe["table"] = "table.exr";
                    json["lobes"].push_back(lobe);
                }
                seeds.add("material", json.dump());
            }
}

void add_specifications(Seeds& seeds) {
    seeds.add("table_spec", R"({"name": "t", "quantity": "albedo", "encoding": "half", "axes": [
        {"axis": "cos_theta", "size": 3, "nodes": "centres", "least": 0.001},
        {"axis": "roughness", "size": 2, "nodes": "descending", "power": 2, "range": [0.1, 1]},
        {"axis": "f0", "size": 3, "nodes": "corners"}], "tolerance": 0.001})");
    seeds.add("table_spec", R"({"quantity": "scale-bias", "encoding": "unorm16", "model": "ggx",
        "axes": [{"axis": "roughness", "size": 4}], "parameters": {}})");
    seeds.add("table_spec", R"({"quantity": "complement", "encoding": "float", "model": "kurt",
        "parameters": {"alpha": 0.1},
        "axes": [{"axis": "ior", "size": 4, "mapping": "openpbr"}, {"axis": "roughness", "size": 4},
                 {"axis": "cos_theta", "size": 4}]})");
    seeds.add("table_spec", R"({"quantity": "multiple-scattering",
        "axes": [{"axis": "ior", "size": 5, "mapping": "power", "range": [0.5, 3]}]})");
    for (const char* text :
         {R"({"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": null, "tilt": 1, "turn": 2})",
          R"({"distribution": "gaussian", "sigma": 0.3})",
          R"({"distribution": "grooves", "sigma": 0.1, "tilt": 0.6})",
          R"({"distribution": "satin", "sigmas": [0.1, 0.3], "weights": [0.7, 0.3]})",
          R"({"distribution": "velvet", "sigma": 0.5})",
          R"({"distribution": "slanted-velvet", "sigma_x": 0.5, "tilt": 0.8})",
          R"({"distribution": "image", "image": "a.png", "extent": 0.5,
              "base": {"distribution": "velvet"}})",
          R"({"distribution": "image", "image": "a.exr", "mapping": "polar",
              "base": {"distribution": "gaussian", "sigma": 1}})",
          R"({"distribution": "tabulated", "file": "p.csv", "tilt": 0.1, "turn": 0.1})",
          R"({"distribution": "tabulated", "file": "a.exr"})",
          R"({"distribution": "mixture", "normalise": false, "parts": [
              {"weight": 0.7, "distribution": "satin"}, {"weight": 0, "distribution": "velvet"},
              {"weight": 1, "distribution": "mixture", "parts": [
                  {"weight": 2, "distribution": "grooves"}]}]})"})
        seeds.add("distribution", text);
    seeds.add("tabulated", "theta_h,p\n0,1\n0.5,0.5\n1,0\n");
    seeds.add("tabulated", "theta_h,phi_h,p\n0,0,1\n0,3,1\n1,0,0.5\n1,3,0.25\n");
    const Json form = {{"vector_width", 4}, {"local_size", 1}, {"block", 1024}, {"candidates", 3}};
    Json entry = {{"device", "device"},
                  {"platform", "platform"},
                  {"driver", "1"},
                  {"kernels", kernel_hash()}};
    entry.update(form);
    seeds.add("tuning", Json{{"tuning", {entry}}}.dump());
    entry["device"] = "other";
    seeds.add("tuning", Json{{"tuning", {entry, 1}}}.dump());
    const Json row = {{"device", "d"}, {"work", "eval"},           {"model", "m"},
                      {"threads", 1},  {"samples_per_second", 10}, {"spread", 0.5}};
    seeds.add("bench_record",
              Json{{"machine", "m"}, {"version", "1"}, {"results", {row, row}}}.dump());
}

void add_runs(Seeds& seeds) {
    Plan plan;
    plan.settings.models = {"kurt", "ward+ggx"};
    plan.settings.lobes = {1, 2};
    plan.settings.isotropic = true;
    plan.settings.orient = true;
    plan.settings.options.ranges = {parse_fix("f0=0.04"), parse_bound("2.alpha=0:1")};
    plan.settings.options.start = parse_material(test::material_example, "start");
    plan.metrics = {Metric::Ngan, Metric::Log};
    plan.folder = "/";
    plan.files = {{"a.binary", std::string(64, 'a'), 12}, {"b.csv", std::string(64, 'b'), 34}};
    for (std::size_t file = 0; file < plan.files.size(); ++file)
        for (const Metric metric : plan.metrics)
            plan.tasks.push_back({std::string(64, 'c'), file,
                                  structure_named("ward+ggx", 1, "lambert", true), metric,
                                  fmt::format("{}.json", file)});
    write_plan(plan, fuzz::folder());
    const std::string path = fuzz::folder() + "/plan.json";
    seeds.add("plan", read_bytes(path));
    std::filesystem::remove(path);
    std::string lines;
    for (const auto& [digit, state] : {std::pair('1', "done"), {'2', "failed"}, {'3', "done"}}) {
        lines += fmt::format(R"({{"id":"{}","state":"{}","finished":1.7e9,"reason":"x"}})",
                             std::string(64, digit), state);
        lines.back() = '\n'; // the fuzzer adds the checksum and the end
    }
    seeds.add("shard_log", lines);
    seeds.add("shard_log", lines.substr(0, lines.size() - 20));
    Json fitted = Json::parse(test::material_example);
    fitted["fit"].update({{"metric", "ngan"},
                          {"error", {{"ngan", 1}, {"log", 1}, {"l2", 1}, {"cbrt", 1}}},
                          {"standard_error", {{"lobes[0].mx", 0.1}, {"kd[R]", nullptr}}},
                          {"samples", 3},
                          {"evaluations", 4},
                          {"seconds", 0.5},
                          {"starts", 0},
                          {"largest_albedo", {{"R", 1.5}, {"theta", 80}, {"channel", "R"}}}});
    seeds.add("fit_folder", fitted.dump());
    seeds.add("fit_folder",
              "file,model,lobes,metric,failed\na.csv,kurt,1,ngan,\"no, \"\"none\"\"\"\n");
    seeds.add("shard_log", sealed(parse_json(lines.substr(0, lines.find('\n')) + "}", "row", "")));
}

/// As other programs write OpenEXR.
void write_as(const std::string& path, Imf::Compression compression, bool tiles) {
    constexpr int width = 6, height = 5;
    Imf::Header header(width, height, 1, {0, 0}, 1, Imf::INCREASING_Y, compression);
    header.channels().insert("Y", Imf::Channel(Imf::HALF));
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    std::vector<half> y(width * height);
    std::vector<unsigned> id(width * height);
    for (std::size_t i = 0; i < y.size(); ++i) {
        y[i] = static_cast<float>(i % 3) / 2;
        id[i] = static_cast<unsigned>(i);
    }
    Imf::FrameBuffer frame;
    frame.insert("Y", Imf::Slice::Make(Imf::HALF, y.data(), header.dataWindow()));
    frame.insert("id", Imf::Slice::Make(Imf::UINT, id.data(), header.dataWindow()));
    if (tiles) {
        header.setTileDescription({4, 4, Imf::MIPMAP_LEVELS});
        Imf::TiledOutputFile file(path.c_str(), header, 0);
        file.setFrameBuffer(frame);
        for (int level = 0; level < file.numLevels(); ++level)
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    } else {
        Imf::OutputFile file(path.c_str(), header, 0);
        file.setFrameBuffer(frame);
        file.writePixels(height);
    }
}

void add_images(Seeds& seeds) {
    for (const ExrPixel pixel : {ExrPixel::Half, ExrPixel::Float})
        seeds.add_file("exr", [&](const std::string& path) {
            write_exr(fuzz::example_image("Y"), path, pixel);
        });
    for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression)
        for (const bool tiles : {false, true})
            seeds.add_file("exr", [&](const std::string& path) {
                write_as(path, static_cast<Imf::Compression>(compression), tiles);
            });
    for (const bool isotropic : {false, true}) {
        seeds.add_file("table_file", [&](const std::string& path) {
            write_table(fuzz::example_table(isotropic), path);
            const Image tables = read_exr_parts(path)[0];
            seeds.add("table_description", tables.metadata.at("microfacet"));
        });
        seeds.add_file("exr", [&](const std::string& path) {
            write_table(fuzz::example_table(isotropic), path);
        });
    }
    seeds.add_file("tabulated", [&](const std::string& path) {
        Image image = fuzz::example_image("p");
        write_exr(image, path, ExrPixel::Float);
    });
    seeds.add_file("tabulated", [&](const std::string& path) {
        Image image = fuzz::example_image("p");
        image.metadata = {{"theta_h", "0,0.1,0.5,1,1.5"}, {"phi_h", "0,1,2,3,4,5"}};
        write_exr(image, path, ExrPixel::Float);
    });
    for (const bool grey : {false, true})
        seeds.add_file("environment", [&](const std::string& path) {
            const std::vector<std::string> channels =
                grey ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
            const std::vector<float> plane = {0.5F, 1, 2, 0.25F, 0, 0.125F, 3, 1};
            write_exr({4, 2, channels, {channels.size(), plane}, {}}, path, ExrPixel::Half);
        });
    seeds.add_file(
        "png", [&](const std::string& path) { fuzz::write_png(fuzz::example_image("Y"), path); });
}

} // namespace

int main(int count, char** arguments) {
    if (count != 2) {
        fmt::print(stderr, "usage: fuzz_seeds FOLDER\n");
        return 2;
    }
    Seeds seeds;
    add_measured(seeds);
    add_materials(seeds);
    add_specifications(seeds);
    add_runs(seeds);
    add_images(seeds);
    seeds.write(arguments[1]);
    std::filesystem::remove_all(fuzz::folder());
    return 0;
}
