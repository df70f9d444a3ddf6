#include "host_tools/network_files/matrix_files.hpp"

#include <Eigen/SparseCore>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <unsupported/Eigen/SparseExtra>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* guide = R"(# A spindle's thermal network as matrices

    C dT/dt = -(K0 + sum_j g_j F_j F_j') T + sum_j g_j F_j F_j' 1 T_env(j) + B q        y = H T

T: temperatures of the named nodes, K. C: capacity.mtx, J/K. K0: conduction.mtx, W/K, rows sum to zero. F_j:
factor_<j>.mtx, m, for the conductance j in W/m2K, counted from 1 in the order of network.json. B:
source_distribution.mtx, one column per heat source in W, columns sum to 1. H: key_points.mtx and part_means.mtx in K
per K, one row each; part_candidates_<p>.mtx: a part's maximum is the largest of its rows.

    deformation [m] = row of deformations.mtx . (T - T_ref)
    contact pressure [Pa] = assembly pressure + row of contact_pressures.mtx . (T - T_ref)

T_ref: reference_temperature_K of network.json, which holds all names in the order of rows and columns, and g, q, T_env
at the operating state. A film along a coolant circuit takes its liquid's temperature for T_env; its g is the channel
law's effective value. Matrix Market, coordinate format, zeros left out, 18 digits: the numbers come back bit for bit.
)";

/// A folder beside the wanted one that becomes it when everything is written, and else goes.
class NewFolder {
 public:
  explicit NewFolder(const std::string& wanted) : wanted_(wanted) {
    std::error_code unknown;
    if (fs::exists(wanted_, unknown) && !(fs::is_directory(wanted_, unknown) && fs::is_empty(wanted_, unknown))) {
      throw rom::InputError({wanted, 0}, "--matrices", "is there already; give a new or empty folder");
    }
    now_ = rom::make_folder_beside(wanted, "--matrices");
  }
  ~NewFolder() {
    std::error_code ignored;
    if (!now_.empty()) fs::remove_all(now_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  std::string file(const std::string& name) const { return (now_ / name).string(); }
  void keep() {
    std::error_code failure;
    fs::permissions(now_, fs::perms(0755), failure);
    if (!failure) fs::rename(now_, wanted_, failure);
    if (failure)
      throw rom::InputError({wanted_.string(), 0}, "--matrices",
                            std::string("cannot be made: ").append(failure.message()));
    now_.clear();
  }

 private:
  fs::path wanted_;
  fs::path now_;
};

void write_matrix(const NewFolder& folder, const std::string& name, const Eigen::MatrixXd& matrix) {
  const Eigen::SparseMatrix<double> entries = matrix.sparseView();
  const std::string path = folder.file(name + ".mtx");
  Eigen::SparseMatrix<double> back;
  // Eigen's writer says nothing of a full disk.
  const bool same = Eigen::saveMarket(entries, path) && Eigen::loadMarket(back, path) &&
                    back.rows() == entries.rows() && back.cols() == entries.cols() && Eigen::MatrixXd(back) == matrix;
  if (!same) throw rom::InputError({path, 0}, "--matrices", "does not come back as it was written");
}

template <class Outputs, class Row>
void write_rows(const NewFolder& folder, const std::string& name, const Outputs& outputs, Row row) {
  if (outputs.empty()) return;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(outputs.size()), row(outputs.front()).size());
  for (std::size_t i = 0; i < outputs.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = row(outputs[i]);
  write_matrix(folder, name, rows);
}

Json names_of(const auto& items) {
  Json names = Json::array();
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

Json conductances_json(const rom::Network& network, const rom::BoundaryValues& values) {
  const rom::Boundaries& boundaries = network.boundaries;
  Json list = Json::array();
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    Json item{{"name", conductance.name},
              {"file", std::string("factor_").append(std::to_string(j + 1)).append(".mtx")},
              {"nominal_W_per_m2K", conductance.nominal_W_per_m2K},
              {"operating_W_per_m2K", values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)]},
              {"area_m2", conductance.area_m2}};
    if (conductance.environment >= 0) {
      item["environment"] = boundaries.environments[static_cast<std::size_t>(conductance.environment)].name;
    }
    list.push_back(item);
  }
  return list;
}

Json manifest(const rom::Network& network) {
  const rom::Boundaries& boundaries = network.boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  Json json{{"spindle", network.spindle},
            {"description_sha256", network.description_hash},
            {"reference_temperature_K", boundaries.reference_temperature_K},
            {"nodes", Json::array()}};
  for (const rom::Node& node : network.nodes) {
    json["nodes"].push_back({{"name", node.name}, {"part", node.part}, {"r_m", node.r_m}, {"z_m", node.z_m}});
  }
  json["conductances"] = conductances_json(network, values);
  json["sources"] = Json::array();
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    json["sources"].push_back(
        {{"name", boundaries.sources[i].name}, {"operating_W", values.heat_W[static_cast<Eigen::Index>(i)]}});
  }
  json["environments"] = Json::array();
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    json["environments"].push_back({{"name", boundaries.environments[i].name},
                                    {"operating_K", values.environment_K[static_cast<Eigen::Index>(i)]}});
  }
  json["circuits"] = Json::array();
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    Json segments = Json::array();
    for (const int segment : boundaries.circuits[c].segments) {
      segments.push_back(boundaries.conductances[static_cast<std::size_t>(segment)].name);
    }
    json["circuits"].push_back({{"name", boundaries.circuits[c].name},
                                {"operating_W_per_K", values.coolant_W_per_K[static_cast<Eigen::Index>(c)]},
                                {"segments", segments}});
  }
  json["key_points"] = names_of(network.key_points);
  json["parts"] = names_of(network.parts);
  json["deformations"] = names_of(network.deformations);
  json["contact_pressures"] = Json::array();
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    json["contact_pressures"].push_back({{"name", output.name}, {"assembly_Pa", output.assembly_pressure_Pa}});
  }
  return json;
}

}  // namespace

void write_matrix_files(const rom::Network& network, const std::string& directory) {
  NewFolder folder(directory);
  write_matrix(folder, "capacity", network.capacity_J_per_K);
  write_matrix(folder, "conduction", network.conduction_W_per_K);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    write_matrix(folder, std::string("factor_").append(std::to_string(j + 1)), network.factors_m[j]);
  }
  if (network.source_distribution.cols() > 0) write_matrix(folder, "source_distribution", network.source_distribution);
  write_rows(folder, "key_points", network.key_points, [](const auto& output) { return output.row.transpose(); });
  write_rows(folder, "part_means", network.parts, [](const auto& output) { return output.mean_row.transpose(); });
  for (std::size_t p = 0; p < network.parts.size(); ++p) {
    write_matrix(folder, std::string("part_candidates_").append(std::to_string(p + 1)),
                 network.parts[p].candidate_rows);
  }
  write_rows(folder, "deformations", network.deformations,
             [](const auto& output) { return output.row_m_per_K.transpose(); });
  write_rows(folder, "contact_pressures", network.contact_pressures,
             [](const auto& output) { return output.row_Pa_per_K.transpose(); });
  rom::write_whole_file(folder.file("network.json"), manifest(network).dump(1) + "\n");
  rom::write_whole_file(folder.file("README.md"), guide);
  folder.keep();
}

}  // namespace spindle_twin::host_tools
