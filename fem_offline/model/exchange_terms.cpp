#include "fem_offline/model/exchange_terms.hpp"

#include "fem_offline/description/model_places.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// The matrix Σ w v vᵀ of ∫ u² dA over faces; w the weights of quadrature points [m²], v the trace of u at a point, or
/// its jump between two bodies.
class ExchangeMatrix {
 public:
  void add(double weight_m2, const std::vector<int>& dofs, const std::vector<double>& values) {
    area_m2_ += weight_m2;
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      for (std::size_t j = 0; j < dofs.size(); ++j) {
        triplets_.emplace_back(dofs[i], dofs[j], weight_m2 * values[i] * values[j]);
      }
    }
  }
  void add_jump(double weight_m2, const Trace& a, const Trace& b) {
    std::vector<int> dofs = a.dofs;
    std::vector<double> values = a.values;
    dofs.insert(dofs.end(), b.dofs.begin(), b.dofs.end());
    for (const double value : b.values) values.push_back(-value);
    add(weight_m2, dofs, values);
  }
  SparseMatrix matrix(int unknowns) const {
    SparseMatrix result(unknowns, unknowns);
    result.setFromTriplets(triplets_.begin(), triplets_.end());
    return result;
  }
  double area_m2() const { return area_m2_; }

 private:
  std::vector<Eigen::Triplet<double>> triplets_;
  double area_m2_ = 0.0;
};

ExchangeMatrix between_parts(const SurfaceRules& rules, PieceKind kind, std::size_t index) {
  ExchangeMatrix exchange;
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind != kind || pair.index != index) continue;
    for (const PairedPoint& point : pair.points) exchange.add_jump(point.weight_m2, point.a, point.b);
  }
  return exchange;
}

/// `air_unknown` -1: to an environment, which is no unknown.
ExchangeMatrix to_surrounding(const Section& section, const SurfaceRules& rules, std::size_t film, int air_unknown) {
  const Trace air = air_unknown >= 0 ? Trace{{air_unknown}, {1.0}} : Trace{};
  ExchangeMatrix exchange;
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    if (!acts_on(film, section.pieces[p])) continue;
    for (const SurfacePoint& point : rules.pieces[p]) exchange.add_jump(point.weight_m2, point.trace, air);
  }
  return exchange;
}

/// The part whose faces the film wets, -1 when there are several.
int only_part(const Section& section, std::size_t film) {
  int part = -1;
  for (const BoundaryPiece& piece : section.pieces) {
    if (!acts_on(film, piece)) continue;
    if (part >= 0 && part != static_cast<int>(piece.part)) return -1;
    part = static_cast<int>(piece.part);
  }
  return part;
}

rom::Conductance contact_record(const Spindle& spindle, const Contact& contact) {
  const Part& part_a = spindle.parts[contact.part_a];
  const Part& part_b = spindle.parts[contact.part_b];
  rom::Conductance conductance;
  conductance.name = part_a.name + "/" + part_b.name;
  conductance.kind = rom::ConductanceKind::contact;
  conductance.nominal_W_per_m2K = contact.conductance_W_per_m2K;
  conductance.physics = contact.physics;
  conductance.part_a = static_cast<int>(contact.part_a);
  conductance.part_b = static_cast<int>(contact.part_b);
  if (contact.fit) {
    conductance.fit = joint_fit(*contact.fit, spindle.materials[part_a.material], spindle.materials[part_b.material]);
  }
  return conductance;
}

rom::Conductance gap_record(const GapFilm& gap) {
  rom::Conductance conductance;
  conductance.name = gap.name;
  conductance.kind = rom::ConductanceKind::gap_film;
  conductance.nominal_W_per_m2K = gap.coefficient_W_per_m2K;
  conductance.part_a = static_cast<int>(gap.part_a);
  conductance.part_b = static_cast<int>(gap.part_b);
  conductance.law = gap.law;
  conductance.physics = gap.physics;
  return conductance;
}

rom::Conductance film_record(const Spindle& spindle, const Section& section, std::size_t index, bool is_air) {
  const Film& film = spindle.films[index];
  rom::Conductance conductance;
  conductance.name = film.name;
  conductance.kind = is_air ? rom::ConductanceKind::air_film : rom::ConductanceKind::environment_film;
  conductance.nominal_W_per_m2K = film.coefficient_W_per_m2K;
  conductance.environment = environment_of(spindle, film.surrounding);
  conductance.part_a = only_part(section, index);
  conductance.law = film.law;
  conductance.physics = film.physics;
  return conductance;
}

}  // namespace

rom::JointFit joint_fit(const InterferenceFit& fit, const Material& inner, const Material& outer) {
  const double a2 = fit.inner_radius_m * fit.inner_radius_m;
  const double b2 = fit.fit_radius_m * fit.fit_radius_m;
  const double c2 = fit.outer_radius_m * fit.outer_radius_m;
  const double give_outer = ((c2 + b2) / (c2 - b2) + outer.poisson_ratio) / outer.youngs_modulus_Pa;
  const double give_inner = ((b2 + a2) / (b2 - a2) - inner.poisson_ratio) / inner.youngs_modulus_Pa;
  const double pressure_Pa_per_m = 1.0 / (fit.fit_radius_m * (give_outer + give_inner));
  return {pressure_Pa_per_m * fit.interference_m, pressure_Pa_per_m * fit.fit_radius_m * inner.expansion_per_K,
          pressure_Pa_per_m * fit.fit_radius_m * outer.expansion_per_K};
}

ExchangeTerms exchange_terms(const Spindle& spindle, const Section& section, const SurfaceRules& rules, int unknowns,
                             const std::vector<int>& air_unknown) {
  ExchangeTerms terms;
  const auto append = [&](const ExchangeMatrix& exchange, rom::Conductance conductance) {
    conductance.area_m2 = exchange.area_m2();
    terms.matrices_m2.push_back(exchange.matrix(unknowns));
    terms.conductances.push_back(std::move(conductance));
  };
  for (const FaceItem& item : face_items(spindle)) {
    const std::size_t i = item.index;
    const Assembles assembles = item.condition->assembles;
    if (assembles != Assembles::conductance && assembles != Assembles::held_temperature) continue;
    if (assembles == Assembles::held_temperature) terms.held.push_back(static_cast<int>(terms.conductances.size()));
    if (*item.condition->piece == PieceKind::contact) {
      append(between_parts(rules, PieceKind::contact, i), contact_record(spindle, spindle.contacts[i]));
    } else if (*item.condition->piece == PieceKind::gap) {
      append(between_parts(rules, PieceKind::gap, i), gap_record(spindle.gap_films[i]));
    } else {
      const int air = air_unknown[spindle.films[i].surrounding];
      append(to_surrounding(section, rules, i, air), film_record(spindle, section, i, air >= 0));
    }
  }
  return terms;
}

}  // namespace spindle_twin::fem_offline
