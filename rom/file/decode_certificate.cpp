#include "rom/file/decode_certificate.hpp"

#include "rom/file/decode_fields.hpp"
#include "rom/file/payload.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

CertificateErrors decode_errors(const spindle_twin_rom_CertificateErrors& message) {
  return {message.key_points_K, message.nose_um, message.part_max_K};
}

std::vector<OutputError> unflatten(const Eigen::VectorXd& numbers, bool limits, const std::string& file,
                                   const std::string& field) {
  const Eigen::Index each = limits ? 4 : 3;
  if (numbers.size() % each != 0) {
    throw InputError({file, 0}, "certificate " + field,
                     std::to_string(numbers.size()) + " numbers, not worst, median" +
                         (limits ? ", mesh and limit of each output" : " and mesh of each output"));
  }
  std::vector<OutputError> errors;
  errors.reserve(static_cast<std::size_t>(numbers.size() / each));
  for (Eigen::Index i = 0; i < numbers.size(); i += each) {
    errors.push_back({numbers[i], numbers[i + 1], numbers[i + 2], limits ? numbers[i + 3] : 0.0});
  }
  return errors;
}

}  // namespace

void attach_certificate(spindle_twin_rom_Certificate& message, FlatErrors& errors) {
  message.key_points_K = attach(errors.key_points_K);
  message.part_means_K = attach(errors.part_means_K);
  message.part_maxima_K = attach(errors.part_maxima_K);
  message.deformations_m = attach(errors.deformations_m);
  message.contact_pressures_Pa = attach(errors.contact_pressures_Pa);
}

Certificate decode_certificate(const spindle_twin_rom_Certificate& message, const FlatErrors& errors,
                               std::uint32_t schema_version, const std::string& file) {
  const bool limits = schema_version >= payload_schema_version_limits;
  Certificate certificate;
  certificate.seed = message.seed;
  certificate.cases = message.cases;
  certificate.worst = decode_errors(message.worst);
  certificate.median = decode_errors(message.median);
  if (limits) {
    certificate.limit = decode_errors(message.limit);
    certificate.limit_rule = {message.limit_content, message.limit_confidence, message.limit_fitted};
  }
  certificate.searched = message.searched;
  certificate.worst_found = decode_errors(message.worst_found);
  certificate.box = {message.box.contact_low, message.box.contact_high, message.box.film_low, message.box.film_high,
                     message.box.speed_high_rpm};
  certificate.mesh_size_m = message.mesh_size_m;
  certificate.fe_unknowns = message.fe_unknowns;
  certificate.key_points_K = unflatten(errors.key_points_K, limits, file, "key_points_K");
  certificate.part_means_K = unflatten(errors.part_means_K, limits, file, "part_means_K");
  certificate.part_maxima_K = unflatten(errors.part_maxima_K, limits, file, "part_maxima_K");
  certificate.deformations_m = unflatten(errors.deformations_m, limits, file, "deformations_m");
  certificate.contact_pressures_Pa = unflatten(errors.contact_pressures_Pa, limits, file, "contact_pressures_Pa");
  return certificate;
}

}  // namespace spindle_twin::rom
