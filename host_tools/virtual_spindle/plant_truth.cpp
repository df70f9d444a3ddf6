#include "host_tools/virtual_spindle/plant_truth.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>
#include <utility>

#include "correction/paper/joint_law.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr double joint_update_s = 10.0;  // each update costs a factorisation; rises move by less than 0.1 K meanwhile
constexpr double joint_exponent = 0.68;

double positive_number(const std::string& text, const std::string& option, bool may_be_negative) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || stop != text.data() + text.size() || !std::isfinite(value) ||
      (!may_be_negative && value <= 0.0)) {
    throw rom::InputError({}, option,
                          "'" + text + "' is not a " + (may_be_negative ? "finite" : "positive finite") + " number");
  }
  return value;
}

/// Calls set(index, value) for every name that matches; throws with the list of names if none does.
template <typename Set>
void for_named(const std::vector<NamedValue>& wanted, const std::vector<std::string>& names, const std::string& option,
               Set set) {
  for (const NamedValue& item : wanted) {
    bool found = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (item.name != "all" && item.name != names[i]) continue;
      if (!names[i].empty()) set(i, item.value);
      found = true;
    }
    if (found) continue;
    std::string list;
    for (const std::string& name : names) {
      if (!name.empty()) list.append(list.empty() ? "" : ", ").append(name);
    }
    throw rom::InputError({}, option, "'" + item.name + "' does not exist; allowed: all, " + list);
  }
}

std::vector<std::string> key_point_names(const fem_offline::AffineModel& model) {
  std::vector<std::string> names;
  for (const fem_offline::FeKeyPoint& point : model.key_points) names.push_back(point.name);
  return names;
}

}  // namespace

NamedValue parse_named_value(const std::string& text, const std::string& option) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) {
    throw rom::InputError({}, option, "'" + text + "' is not NAME=VALUE");
  }
  return {text.substr(0, equals), positive_number(text.substr(equals + 1), option, option == "--offset-K")};
}

ContactSpread parse_contact_spread(const std::string& text) {
  const std::string option = "--contact-spread";
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) {
    throw rom::InputError({}, option, "'" + text + "' is not SEED:FACTOR, as in 7:2.0");
  }
  ContactSpread spread;
  const std::string seed = text.substr(0, colon);
  const auto [stop, error] = std::from_chars(seed.data(), seed.data() + seed.size(), spread.seed);
  if (seed.empty() || error != std::errc() || stop != seed.data() + seed.size()) {
    throw rom::InputError({}, option, "'" + seed + "' is not a whole number >= 0");
  }
  spread.factor = positive_number(text.substr(colon + 1), option, false);
  if (spread.factor < 1.0) throw rom::InputError({}, option, "the factor must be at least 1");
  return spread;
}

rom::CorrectionFactors hidden_factors(const rom::Boundaries& boundaries, const HiddenTruth& truth) {
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  std::vector<std::string> heats;
  for (const rom::HeatSource& source : boundaries.sources) heats.push_back(source.name);
  // Contacts and films share one list; an empty name marks an entry that the option does not reach.
  std::vector<std::string> contacts;
  std::vector<std::string> films;
  for (const rom::Conductance& item : boundaries.conductances) {
    const bool contact = item.kind == rom::ConductanceKind::contact;
    contacts.push_back(contact ? item.name : "");
    films.push_back(contact ? "" : item.name);
  }
  if (truth.contact_spread) {
    std::mt19937_64 random(truth.contact_spread->seed);
    const double width = std::log(truth.contact_spread->factor);
    std::uniform_real_distribution<double> exponent(-width, width);
    for (std::size_t j = 0; j < contacts.size(); ++j) {
      if (!contacts[j].empty()) factors.conductance[static_cast<Eigen::Index>(j)] = std::exp(exponent(random));
    }
  }
  const auto scale = [](Eigen::VectorXd& vector) {
    return [&vector](std::size_t i, double value) { vector[static_cast<Eigen::Index>(i)] *= value; };
  };
  for_named(truth.heat_factors, heats, "--heat-factor", scale(factors.heat));
  for_named(truth.contact_factors, contacts, "--contact-factor", scale(factors.conductance));
  for_named(truth.film_factors, films, "--film-factor", scale(factors.conductance));
  return factors;
}

Plant::Plant(const fem_offline::AffineModel& model, const HiddenTruth& truth, rom::Schedule schedule)
    : model_(model),
      truth_(truth),
      schedule_(std::move(schedule)),
      hidden_(hidden_factors(model.boundaries, truth)),
      present_(hidden_),
      values_(rom::make_boundary_values(model.boundaries)),
      stepper_(model),
      offset_K_(model.key_points.size(), 0.0),
      random_(truth.seed) {
  for_named(truth_.offsets_K, key_point_names(model), "--offset-K",
            [this](std::size_t i, double value) { offset_K_[i] += value; });
  stepper_.set_uniform_temperature(model.boundaries.reference_temperature_K);
  snapshot_.operating = model.boundaries.operating;
  rom::state_at(schedule_, 0.0, snapshot_.operating);
  snapshot_.measured_degC.resize(model.key_points.size());
  snapshot_.key_point_degC.resize(model.key_points.size());
  snapshot_.part_max_degC.resize(model.parts.size());
  snapshot_.deformation_um.resize(model.deformations.size());
  observe();
}

void Plant::advance(double step_s) {
  if (truth_.joint_law && snapshot_.time_s >= joints_due_s_) update_joints();
  rom::state_at(schedule_, snapshot_.time_s, snapshot_.operating);
  rom::evaluate_boundaries(model_.boundaries, snapshot_.operating, present_, values_);
  stepper_.advance(step_s, step_s, values_);
  snapshot_.time_s += step_s;
  ++snapshot_.steps;
  rom::state_at(schedule_, snapshot_.time_s, snapshot_.operating);
  observe();
}

void Plant::update_joints() {
  joints_due_s_ = snapshot_.time_s + joint_update_s;
  const auto rise_K = [&](int part) {
    return model_.parts[static_cast<std::size_t>(part)].mean_row.dot(stepper_.temperatures_K()) -
           model_.boundaries.reference_temperature_K;
  };
  for (std::size_t j = 0; j < model_.boundaries.conductances.size(); ++j) {
    const rom::Conductance& joint = model_.boundaries.conductances[j];
    if (!joint.fit || joint.part_a < 0 || joint.part_b < 0) continue;
    const auto index = static_cast<Eigen::Index>(j);
    present_.conductance[index] = hidden_.conductance[index] /
                                  correction::joint_resistance_ratio(*joint.fit, rise_K(joint.part_a),
                                                                     rise_K(joint.part_b), joint_exponent, 0.1, 10.0);
  }
}

void Plant::observe() {
  const Eigen::VectorXd& temperatures_K = stepper_.temperatures_K();
  std::normal_distribution<double> noise(0.0, 1.0);
  for (std::size_t k = 0; k < model_.key_points.size(); ++k) {
    const double true_degC = model_.key_points[k].row.dot(temperatures_K) - rom::zero_degC_K;
    snapshot_.key_point_degC[k] = true_degC;
    snapshot_.measured_degC[k] = true_degC + offset_K_[k] + truth_.noise_K * noise(random_);
  }
  for (std::size_t p = 0; p < model_.parts.size(); ++p) {
    double maximum_K = temperatures_K[model_.parts[p].dofs.front()];
    for (const int dof : model_.parts[p].dofs) maximum_K = std::max(maximum_K, temperatures_K[dof]);
    snapshot_.part_max_degC[p] = maximum_K - rom::zero_degC_K;
  }
  for (std::size_t d = 0; d < model_.deformations.size(); ++d) {
    snapshot_.deformation_um[d] =
        rom::um_per_m * model_.deformations[d].row_m_per_K.dot(
                            (temperatures_K.array() - model_.boundaries.reference_temperature_K).matrix());
  }
}

void write_plant_header(std::ostream& out, const fem_offline::AffineModel& model) {
  out << "time_s,speed_rpm,load";
  for (const rom::Environment& environment : model.boundaries.environments) out << ',' << environment.name << "_degC";
  for (const std::string& name : key_point_names(model)) out << ",key_point." << name << "_degC";
  for (const std::string& name : key_point_names(model)) out << ",measured." << name << "_degC";
  for (const fem_offline::FePart& part : model.parts) out << ",part_maximum." << part.name << "_degC";
  for (const fem_offline::FeDeformation& output : model.deformations) out << ",deformation." << output.name << "_um";
  out << '\n';
}

void write_plant_row(std::ostream& out, const PlantSnapshot& snapshot) {
  const auto old_precision = out.precision(9);
  out << snapshot.time_s << ',' << snapshot.operating.speed_rpm << ',' << snapshot.operating.load;
  for (const double temperature_K : snapshot.operating.environment_K) out << ',' << temperature_K - rom::zero_degC_K;
  for (const auto* columns :
       {&snapshot.key_point_degC, &snapshot.measured_degC, &snapshot.part_max_degC, &snapshot.deformation_um}) {
    for (const double value : *columns) out << ',' << value;
  }
  out << '\n';
  out.precision(old_precision);
}

}  // namespace spindle_twin::host_tools
