#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/network.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {

inline constexpr double megapascal_per_pascal = 1e-6;

/// What reading has already required, as numbers.
struct Checks {
  double capacity_asymmetry = 0.0;    ///< of the largest entry
  double conduction_asymmetry = 0.0;  ///< of the largest entry
  double row_sum = 0.0;               ///< largest |K₀ 1|, of the largest entry
  double exchange_column_sum = 0.0;   ///< largest column sum of an exchange's factor, of its largest entry
  double smallest_capacity_J_per_K = 0.0;
  double capacity_condition = 0.0;
  double smallest_conduction_W_per_K = 0.0;
};

/// A network file and what follows from it; what every form of `spindle-twin inspect` shows.
struct Inspection {
  rom::Network network;
  std::uint32_t schema_version = 0;  ///< of the file's payload
  std::string sha256;                ///< of the file's payload, hex
  std::string signed_by;             ///< public key, hex; empty: not signed
  rom::BoundaryValues values;        ///< at the operating state, nothing corrected; laws at its steady temperatures
  Eigen::VectorXd time_constants_s;
  rom::CoolantOutlets coolant;  ///< in the steady state at the operating state
  Checks checks;
};

/// One line of a certificate; errors in `unit`, the unit that people read: K, um, MPa.
struct CertifiedOutput {
  std::string kind;  ///< key point, part mean, part maximum, deformation, contact pressure
  std::string name;
  std::string unit;
  rom::OutputError error;
};

/// What the limits of a certificate promise, in words.
std::string limit_text(const rom::CertificateLimit& rule);

/// Every output that the certificate has an error for.
std::vector<CertifiedOutput> certified_outputs(const rom::Network& network);

/// Reads and checks. Throws rom::InputError.
Inspection inspect(const std::string& path);

/// On stdout, for people and for programs; `steady_state` as network_page/steady_state.hpp makes it, or null.
void print_table(const Inspection& result);
void print_json(const Inspection& result, const nlohmann::json& steady_state);

}  // namespace spindle_twin::host_tools
