#include "fem_offline/exchange_files/freefem_growth.hpp"

#include <iomanip>
#include <sstream>

#include "fem_offline/exchange_files/freefem_meshes.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Surface springs where nodes do not match, on the strips of the pair.
void write_ties(DeckFile& file, const FreefemDeck& deck) {
  for (std::size_t p = 0; p < deck.model.pairs.size(); ++p) {
    const double tie_N_per_m3 = deck.model.pairs[p].tie_N_per_m3;
    if (tie_N_per_m3 == 0.0) continue;
    const std::string n = std::to_string(p);
    for (const std::string side : {"a", "b"}) {
      file << "fespace Y" << n << side << "(L" << n << side << ", [P2, P2]);\nmatrix Iw" << n << side
           << " = interpolate(Y" << n << side << ", W);\n";
    }
    file << "varf tie" << n << "([u, w], [s, t]) = int1d(L" << n << "a, 1)(ring * " << tie_N_per_m3
         << " * (u * s + w * t));\nmatrix B" << n << " = tie" << n << "(Y" << n << "a, Y" << n << "a);\nmatrix jump"
         << n << " = Iw" << n << "a + (-1.) * Iw" << n << "b;\nmatrix pull" << n << " = B" << n << " * jump" << n
         << ";\nmatrix bond" << n << " = jump" << n << "' * pull" << n << ";\nE = E + bond" << n << ";\n";
  }
}

}  // namespace

void write_elastic(DeckFile& file, const FreefemDeck& deck) {
  const Spindle& spindle = deck.spindle;
  file << "\n// growth: all parts bonded, temperatures may jump between them\n"
       << "mesh All = readmesh(\"bonded.msh\");\nfespace W(All, [P2, P2]);\n"
       << "macro div(u, w) (dx(u) + u / x + dy(w)) //\nvarf elastic([u, w], [s, t]) = ";
  std::ostringstream load, held;
  load << std::setprecision(12) << std::showpoint;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    const Material& material = spindle.materials[spindle.parts[part].material];
    const double nu = material.poisson_ratio;
    const double lambda = material.youngs_modulus_Pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    const double mu = material.youngs_modulus_Pa / (2.0 * (1.0 + nu));
    file << (part > 0 ? "\n  + " : "") << "int2d(All, " << part + 1 << ")(ring * (" << lambda
         << " * div(u, w) * div(s, t) + " << mu
         << " * (2 * (dx(u) * dx(s) + u * s / x^2 + dy(w) * dy(t)) + (dy(u) + dx(w)) * (dy(s) + dx(t)))))";
    load << (part > 0 ? "\n  + " : "") << "int2d(All, " << part + 1 << ")(ring * "
         << material.expansion_per_K * (3.0 * lambda + 2.0 * mu) << " * (T" << part << " - "
         << degC(spindle.operating.reference_temperature_K) << ") * div(s, t))";
  }
  for (const Support& support : spindle.supports) {
    for (const std::size_t p : pieces_in(deck.model, support.part, support.face)) {
      held << "\n  + on(" << p + 1 << ", w = 0)";
    }
  }
  for (std::size_t p = 0; p < deck.model.section.pieces.size(); ++p) {
    if (deck.model.section.pieces[p].kind == PieceKind::axis) held << "\n  + on(" << p + 1 << ", u = 0)";
  }
  file << held.str() << ";\nmatrix E = elastic(W, W);\n";
  write_ties(file, deck);
  file << "set(E, solver = sparsesolver);\n"
       << "varf expansion([u, w], [s, t]) = " << load.str() << held.str() << ";\n";
}

void write_growth_report(DeckFile& file, const FreefemDeck& deck) {
  const Spindle& spindle = deck.spindle;
  file << "  W [u, w];\n  real[int] F = expansion(0, W);\n  u[] = E^-1 * F;\n";
  for (std::size_t d = 0; d < spindle.deformations.size(); ++d) {
    const DeformationOutput& output = spindle.deformations[d];
    std::string labels;
    for (const std::size_t p : pieces_in(deck.model, output.part, output.face)) labels += ", " + std::to_string(p + 1);
    file << "  real moved" << d << " = " << rom::um_per_m * output.sign << " * int1d(All" << labels << ")(x * "
         << (output.direction == Direction::radial ? "u" : "w") << ") / int1d(All" << labels << ")(x)";
    if (output.minus) file << " - moved" << *output.minus;
    file << ";\n  cout << state << \" deformation_um " << output.name << " \" << moved" << d << " << endl;\n";
  }
}

}  // namespace spindle_twin::fem_offline
