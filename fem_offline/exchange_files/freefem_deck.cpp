#include "fem_offline/exchange_files/freefem_deck.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "fem_offline/exchange_files/deck_files.hpp"
#include "fem_offline/exchange_files/freefem_growth.hpp"
#include "fem_offline/exchange_files/freefem_meshes.hpp"
#include "fem_offline/exchange_files/freefem_terms.hpp"

namespace spindle_twin::fem_offline {
namespace {

using Deck = FreefemDeck;

void write_block_matrix(DeckFile& file, const std::string& name, std::size_t size, const Blocks& blocks) {
  file << "matrix " << name << " = [\n";
  for (std::size_t row = 0; row < size; ++row) {
    file << "  [";
    for (std::size_t column = 0; column < size; ++column) {
      const auto found = blocks.find({row, column});
      file << (column > 0 ? ", " : "") << (found == blocks.end() ? "0" : found->second);
    }
    file << (row + 1 < size ? "],\n" : "]\n");
  }
  file << "];\n";
}

void write_report(DeckFile& file, const Deck& deck) {
  const Spindle& spindle = deck.spindle;
  file << "\n// one line per figure: state kind name value [value]\nfunc int report(string state, real[int] & X) {\n";
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    file << "  T" << part << "[] = X(first(" << part << "):first(" << part + 1 << ") - 1);\n"
         << "  cout << state << \" part " << spindle.parts[part].name << " \" << T" << part << "[].max << \" \" << T"
         << part << "[].min << endl;\n";
  }
  for (const KeyPoint& point : spindle.key_points) {
    file << "  cout << state << \" key_point " << point.name << " \" << T" << point.part << "(" << point.at.r_m << ", "
         << point.at.z_m << ") << endl;\n";
  }
  for (std::size_t f = 0; f < deck.model.fluids.size(); ++f) write_fluid_report(file, deck, f);
  if (!deck.model.deformations.empty()) write_growth_report(file, deck);
  file << "  return 0;\n}\n";
}

void write_solutions(DeckFile& file, const Deck& deck) {
  const DeckPlan& plan = deck.plan;
  file << "\n// steady state\nset(K, solver = sparsesolver);\nreal[int] X = K^-1 * Q;\nreport(\"steady\", X);\n"
       << "\n// transient from one temperature: BDF2, constant step, one backward Euler step to begin with\n"
       << "real step = " << plan.constant_step_s << ";\nmatrix first1 = (1. / step) * C + K;\n"
       << "set(first1, solver = sparsesolver);\nreal begun = clock();\nmatrix S = (1.5 / step) * C + K;\n"
       << "set(S, solver = sparsesolver);\nreal[int] Z(X.n), before(X.n), R(X.n), H(X.n);\n"
       << "before = " << degC(plan.start_K) << ";\nR = C * before;\nR *= 1. / step;\nR += Q;\nZ = first1^-1 * R;\n"
       << "H = S^-1 * R;\ncout << \"timing factorise_s \" << clock() - begun << endl;\n"
       << "real spent = 0;\nint steps = 1;\n";
  for (const double until_s : plan.output_times_s) {
    const long until = std::lround(until_s / plan.constant_step_s);
    file << "begun = clock();\nwhile (steps < " << until << ") {\n"
         << "  H = 4 * Z - before;\n  R = C * H;\n  R *= 0.5 / step;\n  R += Q;\n  before = Z;\n  Z = S^-1 * R;\n  "
            "++steps;\n}\n"
         << "spent += clock() - begun;\nreport(\"" << std::lround(until_s) << "s\", Z);\n";
  }
  file << "cout << \"timing step_s \" << spent / (steps - 1) << endl;\n";
}

void write_script(const Deck& deck, const std::string& directory) {
  const std::size_t parts = deck.spindle.parts.size();
  const std::size_t blocks_in_row = parts + deck.model.fluids.size();
  DeckFile file(directory, "spindle.edp");
  file << "// FreeFEM deck of the spindle '" << deck.spindle.name << "': x = r, y = z, SI, degC.\n"
       << "cout.precision(12);\nmacro ring() (2 * pi * x) //\n";
  for (std::size_t part = 0; part < parts; ++part) write_part_terms(file, deck, part);
  file << "\n// contacts, gaps, volumes of air and the liquid of coolant circuits\n";
  const Blocks conduction = write_coupling(file, deck);
  write_block_matrix(file, "K", blocks_in_row, conduction);
  Blocks capacity;
  for (std::size_t part = 0; part < parts; ++part)
    capacity[{part, part}] = std::string("C").append(std::to_string(part));
  for (std::size_t f = 0; f < deck.model.fluids.size(); ++f) {
    if (deck.model.fluids[f].circuit) continue;
    std::ostringstream number;
    number << std::setprecision(12) << std::showpoint;
    number << deck.spindle.surroundings[deck.model.fluids[f].surrounding].capacity_J_per_K;
    capacity[{parts + f, parts + f}] = number.str();
  }
  write_block_matrix(file, "C", blocks_in_row, capacity);
  file << "int[int] first(" << blocks_in_row + 1 << ");\nfirst(0) = 0;\n";
  for (std::size_t part = 0; part < parts; ++part) {
    file << "first(" << part + 1 << ") = first(" << part << ") + V" << part << ".ndof;\n";
  }
  for (std::size_t v = parts; v < blocks_in_row; ++v) file << "first(" << v + 1 << ") = first(" << v << ") + 1;\n";
  file << "real[int] Q(first(" << blocks_in_row << "));\nQ = 0;\n";
  for (std::size_t part = 0; part < parts; ++part) {
    file << "Q(first(" << part << "):first(" << part + 1 << ") - 1) = Q" << part << ";\n";
  }
  for (std::size_t f = 0; f < deck.model.fluids.size(); ++f) {
    const DeckFluid& fluid = deck.model.fluids[f];
    if (!fluid.circuit || fluid.upstream) continue;
    file << "Q(first(" << parts + f << ")) = " << degC(deck.plan.surrounding_K[fluid.surrounding]) << ";\n";
  }
  if (!deck.model.deformations.empty()) write_elastic(file, deck);
  write_report(file, deck);
  write_solutions(file, deck);
  file.close();
}

void write_freefem_readme(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  DeckFile file(directory, "README");
  file
      << "FreeFEM deck of the spindle '" << spindle.name << "' (SI, degC; axisymmetric, x = r, y = z; P2).\n"
      << "Run in this folder: FreeFem++ -nw -ng -v 0 spindle.edp\n"
      << "Prints the steady state and the transient, one line per figure: state, kind, name, value (parts: maximum and "
         "minimum; air and liquid: temperature and heat from the walls).\n";
  if (!deck.growth_left_out.empty()) file << "Without growth: " << deck.growth_left_out << "\n";
  file.close();
}

}  // namespace

void write_freefem_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                        const std::string& directory) {
  make_deck_folder(directory);
  write_freefem_meshes(spindle, deck, directory);
  write_script({spindle, deck, plan}, directory);
  write_freefem_readme(spindle, deck, directory);
}

}  // namespace spindle_twin::fem_offline
