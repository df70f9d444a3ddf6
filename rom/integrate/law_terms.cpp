#include "rom/integrate/law_terms.hpp"

#include <cmath>
#include <stdexcept>

#include "rom/boundary_values/held_law.hpp"
#include "rom/laws/channel_law.hpp"

namespace spindle_twin::rom {
namespace {

constexpr std::array<LawInput, law_readings> read_inputs = {LawInput::first_K, LawInput::second_K,
                                                            LawInput::pressure_Pa, LawInput::displacement_m};

template <class Item>
const Item& at(const std::vector<Item>& list, int index) {
  if (index < 0 || index >= static_cast<int>(list.size())) {
    throw std::invalid_argument("a law reads something that does not exist");
  }
  return list[static_cast<std::size_t>(index)];
}

struct Evaluated {
  double value = 0.0;
  std::array<double, law_readings> slope{};
};

/// One law, what it reads of the state given by `reading(k)`.
template <class Reading>
Evaluated evaluate_term(const LawTerm& term, const BoundaryValues& values, const Reading& reading) {
  LawState state = nominal_state(term.bound, values.laws, values.environment_K);
  std::array<double, law_readings> by_reading{};
  for (std::size_t k = 0; k < law_readings; ++k) {
    if (term.reading[k] < 0) continue;
    by_reading[k] = read_inputs[k] == LawInput::displacement_m ? term.bound.displacement_sign : 1.0;
    state[read_inputs[k]] = by_reading[k] * reading(term.reading[k]);
  }
  const double factor =
      term.source >= 0 ? values.laws.heat_factor[term.source] : values.laws.conductance_factor[term.conductance];
  const LawEvaluation found = evaluate(term.bound.law, state);
  Evaluated result{factor * found.value, {}};
  double by_value = factor;
  if (term.segment >= 0) {
    const double flow_W_per_K = std::abs(values.coolant_W_per_K[term.circuit]);
    const auto effective = channel_W_per_m2K(Dual<1>::variable(result.value, 0), term.area_m2, Dual<1>(flow_W_per_K));
    result.value = effective.value;
    by_value *= effective.slope[0];
  }
  for (std::size_t k = 0; k < law_readings; ++k) result.slope[k] = by_value * by_reading[k] * found.by(read_inputs[k]);
  return result;
}

void store(const LawTerm& term, double value, BoundaryValues& values) {
  if (term.source >= 0) {
    values.heat_W[term.source] = value;
  } else {
    values.conductance_W_per_m2K[term.conductance] = value;
  }
}

}  // namespace

Eigen::Index LawTerms::add_reading(const Eigen::VectorXd& nodal_row, double offset_at_0_K) {
  for (Eigen::Index k = 0; k < nodal_rows_.cols(); ++k) {
    if (nodal_rows_.col(k) == nodal_row && nodal_offset_[k] == offset_at_0_K) return k;
  }
  nodal_rows_.conservativeResize(nodal_row.size(), nodal_rows_.cols() + 1);
  nodal_rows_.rightCols(1) = nodal_row;
  nodal_offset_.conservativeResize(nodal_rows_.cols());
  nodal_offset_.tail(1)[0] = offset_at_0_K;
  return nodal_rows_.cols() - 1;
}

LawTerms::LawTerms(const Network& network, const Eigen::MatrixXd& capacity_root, const CoolantSegments& segments)
    : nodal_rows_(capacity_root.rows(), 0) {
  const Boundaries& boundaries = network.boundaries;
  const double reference_K = boundaries.reference_temperature_K;
  const auto root = capacity_root.triangularView<Eigen::Lower>();
  const auto read_state = [&](LawTerm& term) {
    const BoundLaw& bound = term.bound;
    const auto mean = [&](const LawTemperature& temperature) {
      if (temperature.environment >= 0) at(boundaries.environments, temperature.environment);
      return temperature.part < 0 ? -1 : add_reading(at(network.parts, temperature.part).mean_row, 0.0);
    };
    term.reading = {mean(bound.first), mean(bound.second), -1, -1};
    if (bound.pressure >= 0) {
      const ContactPressureOutput& output = at(network.contact_pressures, bound.pressure);
      term.reading[2] =
          add_reading(output.row_Pa_per_K, output.assembly_pressure_Pa - output.row_Pa_per_K.sum() * reference_K);
    }
    if (bound.displacement >= 0) {
      const Eigen::VectorXd& row = at(network.deformations, bound.displacement).row_m_per_K;
      term.reading[3] = add_reading(row, -row.sum() * reference_K);
    }
    if (bound.circuit >= 0) at(boundaries.circuits, bound.circuit);
  };
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    if (!boundaries.sources[i].physics) continue;
    LawTerm term;
    term.bound = *boundaries.sources[i].physics;
    term.source = static_cast<int>(i);
    read_state(term);
    term.direction = network.source_distribution.col(static_cast<Eigen::Index>(i));
    root.solveInPlace(term.direction);
    list_.push_back(std::move(term));
  }
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const Conductance& conductance = boundaries.conductances[j];
    if (!conductance.physics) continue;
    LawTerm term;
    term.bound = *conductance.physics;
    term.conductance = static_cast<int>(j);
    term.environment = conductance.environment;
    read_state(term);
    term.direction = network.factors_m[j];
    term.column_sums = network.factors_m[j].colwise().sum().transpose();
    if (term.environment < 0) term.column_sums.setZero();
    root.solveInPlace(term.direction);
    for (std::size_t c = 0; c + 1 < segments.first.size(); ++c) {
      for (int s = segments.first[c]; s < segments.first[c + 1]; ++s) {
        if (segments.conductance[static_cast<std::size_t>(s)] != term.conductance) continue;
        term.segment = s;
        term.circuit = static_cast<int>(c);
        term.area_m2 = conductance.area_m2;
      }
    }
    list_.push_back(std::move(term));
  }
  rows_ = nodal_rows_;
  if (rows_.cols() > 0) root.solveInPlace(rows_);
  offset_ = nodal_offset_ + nodal_rows_.colwise().sum().transpose() * reference_K;
}

void LawTerms::evaluate(const Eigen::VectorXd& readings, BoundaryValues& values) const {
  for (const LawTerm& term : list_) {
    store(term, evaluate_term(term, values, [&](Eigen::Index k) { return readings[k]; }).value, values);
  }
}

void LawTerms::evaluate(const Eigen::VectorXd& readings, BoundaryValues& values, Eigen::MatrixXd& slopes) const {
  for (std::size_t t = 0; t < list_.size(); ++t) {
    const Evaluated found = evaluate_term(list_[t], values, [&](Eigen::Index k) { return readings[k]; });
    store(list_[t], found.value, values);
    for (std::size_t k = 0; k < law_readings; ++k) {
      slopes(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = found.slope[k];
    }
  }
}

void LawTerms::at_temperatures(const Eigen::VectorXd& temperatures_K, BoundaryValues& values) const {
  for (const LawTerm& term : list_) {
    const auto reading = [&](Eigen::Index k) { return nodal_rows_.col(k).dot(temperatures_K) + nodal_offset_[k]; };
    store(term, evaluate_term(term, values, reading).value, values);
  }
}

}  // namespace spindle_twin::rom
