#include "fem_offline/model/exchange_terms.hpp"

#include "fem_offline/description/model_places.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Sum of w (Σ vᵢ uᵢ)², where the trace may hold a jump between two bodies.
class Quadratic {
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

Quadratic between_parts(const SurfaceRules& rules, PieceKind kind, std::size_t index) {
  Quadratic form;
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind != kind || pair.index != index) continue;
    for (const PairedPoint& point : pair.points) form.add_jump(point.weight_m2, point.a, point.b);
  }
  return form;
}

void append(ExchangeTerms& terms, const Quadratic& form, int unknowns, rom::Conductance conductance) {
  conductance.area_m2 = form.area_m2();
  terms.matrices_m2.push_back(form.matrix(unknowns));
  terms.conductances.push_back(std::move(conductance));
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

void append_film(ExchangeTerms& terms, const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                 int unknowns, std::size_t index, int environment, int air_unknown) {
  const Film& film = spindle.films[index];
  const Trace air = air_unknown >= 0 ? Trace{{air_unknown}, {1.0}} : Trace{};
  Quadratic form;
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    if (!acts_on(index, section.pieces[p])) continue;
    for (const SurfacePoint& point : rules.pieces[p]) form.add_jump(point.weight_m2, point.trace, air);
  }
  rom::Conductance conductance;
  conductance.name = film.name;
  conductance.kind = air_unknown >= 0 ? rom::ConductanceKind::air_film : rom::ConductanceKind::environment_film;
  conductance.nominal_W_per_m2K = film.coefficient_W_per_m2K;
  conductance.environment = environment;
  conductance.part_a = only_part(section, index);
  conductance.law = film.law;
  conductance.physics = film.physics;
  append(terms, form, unknowns, std::move(conductance));
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
  for (std::size_t i = 0; i < spindle.contacts.size(); ++i) {
    const Contact& contact = spindle.contacts[i];
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
    append(terms, between_parts(rules, PieceKind::contact, i), unknowns, std::move(conductance));
  }
  for (std::size_t i = 0; i < spindle.gap_films.size(); ++i) {
    const GapFilm& gap = spindle.gap_films[i];
    rom::Conductance conductance;
    conductance.name = gap.name;
    conductance.kind = rom::ConductanceKind::gap_film;
    conductance.nominal_W_per_m2K = gap.coefficient_W_per_m2K;
    conductance.part_a = static_cast<int>(gap.part_a);
    conductance.part_b = static_cast<int>(gap.part_b);
    conductance.law = gap.law;
    conductance.physics = gap.physics;
    append(terms, between_parts(rules, PieceKind::gap, i), unknowns, std::move(conductance));
  }
  for (std::size_t i = 0; i < spindle.films.size(); ++i) {
    const std::size_t surrounding = spindle.films[i].surrounding;
    append_film(terms, spindle, section, rules, unknowns, i, environment_of(spindle, surrounding),
                air_unknown[surrounding]);
  }
  return terms;
}

}  // namespace spindle_twin::fem_offline
