#include "fem_offline/exchange_files/freefem_terms.hpp"

#include <iomanip>
#include <sstream>
#include <vector>

#include "fem_offline/exchange_files/freefem_meshes.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Text with numbers as in a DeckFile.
std::ostringstream term_stream() {
  std::ostringstream term;
  term << std::setprecision(12) << std::showpoint;
  return term;
}

/// Blocks of the conduction matrix as they come together; sums get names of their own.
class BlockSums {
 public:
  explicit BlockSums(DeckFile& file) : file_(file) {}

  void add(std::size_t row, std::size_t column, const std::string& matrix) {
    std::string& block = blocks_[{row, column}];
    if (!block.empty()) {
      const std::string sum = std::string("S").append(std::to_string(++sums_));
      file_ << "matrix " << sum << " = " << block << " + " << matrix << ";\n";
      block = sum;
    } else {
      block = matrix;
    }
  }
  void set(std::size_t row, std::size_t column, const std::string& name) { blocks_[{row, column}] = name; }
  Blocks blocks() const { return blocks_; }

 private:
  DeckFile& file_;
  Blocks blocks_;
  std::size_t sums_ = 0;
};

void write_matching_pairs(DeckFile& file, const FreefemDeck& deck, BlockSums& sums) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::string>> terms;
  const auto& pieces = deck.model.section.pieces;
  for (const DeckPair& pair : deck.model.pairs) {
    if (!pair.matching) continue;
    const Point offset = offset_of(deck.model, pair);
    std::ostringstream term = term_stream();
    const std::size_t a = pieces[pair.piece_a].part;
    term << "int1d(Th" << a << ", " << pair.piece_a + 1;
    if (pair.kind == PieceKind::gap) term << ", mapu = [x + " << offset.r_m << ", y + " << offset.z_m << "]";
    term << ")(-2 * pi * (x + " << 0.5 * offset.r_m << ") * " << pair.conductance_W_per_m2K << " * u * v)";
    terms[{a, pieces[pair.piece_b].part}].push_back(term.str());
  }
  for (const auto& [both, list] : terms) {
    const auto& [a, b] = both;
    const std::string name = std::to_string(a).append("x").append(std::to_string(b));
    file << "varf m" << name << "(u, v) = ";
    for (std::size_t i = 0; i < list.size(); ++i) file << (i > 0 ? "\n  + " : "") << list[i];
    file << ";\nmatrix M" << name << " = m" << name << "(V" << b << ", V" << a << ");\nmatrix N" << name << " = M"
         << name << "';\n";
    // Both orders of a pair of parts may occur, as in a contact and a gap between the same two.
    sums.add(a, b, std::string("M").append(name));
    sums.add(b, a, std::string("N").append(name));
  }
}

/// With I the interpolation to the strip and M the integral along it: the jump I_a T_a − I_b T_b passes heat.
void write_other_pairs(DeckFile& file, const FreefemDeck& deck, BlockSums& sums) {
  const auto& pieces = deck.model.section.pieces;
  for (std::size_t p = 0; p < deck.model.pairs.size(); ++p) {
    const DeckPair& pair = deck.model.pairs[p];
    if (pair.matching) continue;
    const std::size_t parts[] = {pieces[pair.piece_a].part, pieces[pair.piece_b].part};
    for (const bool first : {true, false}) {
      const std::string name = std::to_string(p).append(first ? "a" : "b");
      file << "mesh L" << name << " = readmesh(\"" << strip_name(p, first) << ".msh\");\nfespace U" << name << "(L"
           << name << ", P2);\nmatrix I" << name << " = interpolate(U" << name << ", V" << parts[first ? 0 : 1]
           << ");\n";
    }
    const std::string n = std::to_string(p);
    file << "varf l" << n << "(u, v) = int1d(L" << n << "a, 1)(2 * pi * (x + " << 0.5 * offset_of(deck.model, pair).r_m
         << ") * " << pair.conductance_W_per_m2K << " * u * v);\nmatrix J" << n << " = l" << n << "(U" << n << "a, U"
         << n << "a);\nmatrix F" << n << "a = J" << n << " * I" << n << "a;\nmatrix F" << n << "b = J" << n << " * I"
         << n << "b;\nmatrix D" << n << "a = I" << n << "a' * F" << n << "a;\nmatrix D" << n << "b = I" << n << "b' * F"
         << n << "b;\nmatrix G" << n << " = I" << n << "a' * F" << n << "b;\nmatrix O" << n << "a = (-1.) * G" << n
         << ";\nmatrix O" << n << "b = O" << n << "a';\n";
    sums.add(parts[0], parts[0], std::string("D").append(n).append("a"));
    sums.add(parts[1], parts[1], std::string("D").append(n).append("b"));
    sums.add(parts[0], parts[1], std::string("O").append(n).append("a"));
    sums.add(parts[1], parts[0], std::string("O").append(n).append("b"));
  }
}

/// The film of one part towards one fluid: −∫ g v dA.
std::string wetted_integral(const FreefemDeck& deck, std::size_t part, std::size_t fluid) {
  std::ostringstream integral = term_stream();
  for (const DeckFilm& film : deck.model.films) {
    if (film.fluid != fluid || deck.model.section.pieces[film.piece].part != part) continue;
    integral << (integral.tellp() > 0 ? " + " : "") << "int1d(Th" << part << ", " << film.piece + 1 << ")(-ring * "
             << film.coefficient_W_per_m2K << " * v)";
  }
  return integral.str();
}

std::string wetted_name(std::size_t part, std::size_t fluid) {
  return std::string("A").append(std::to_string(part)).append("v").append(std::to_string(fluid));
}

void write_fluids(DeckFile& file, const FreefemDeck& deck, BlockSums& sums) {
  const std::size_t parts = deck.spindle.parts.size();
  const auto& fluids = deck.model.fluids;
  for (std::size_t f = 0; f < fluids.size(); ++f) {
    const std::string wet = std::string("wet").append(std::to_string(f));
    file << "real " << wet << " = 0;\n";
    for (std::size_t part = 0; part < parts; ++part) {
      const std::string integral = wetted_integral(deck, part, f), name = wetted_name(part, f);
      if (integral.empty()) continue;
      file << "varf a" << name << "(u, v) = " << integral << ";\nreal[int] " << name << " = a" << name << "(0, V"
           << part << ");\n"
           << wet << " -= " << name << ".sum;\n";
      sums.set(part, parts + f, name);
      if (!fluids[f].circuit) sums.set(parts + f, part, std::string(name).append("'"));
      for (std::size_t next = 0; next < fluids.size(); ++next) {
        if (fluids[next].upstream == f) sums.set(parts + next, part, std::string(name).append("'"));
      }
    }
    if (!fluids[f].circuit) sums.set(parts + f, parts + f, wet);
  }
  for (std::size_t f = 0; f < fluids.size(); ++f) {
    if (!fluids[f].circuit) continue;
    const std::string number = std::to_string(f);
    file << "real own" << number << " = " << (fluids[f].upstream ? fluids[f].flow_W_per_K : 1.0) << ";\n";
    sums.set(parts + f, parts + f, std::string("own").append(number));
    if (!fluids[f].upstream) continue;
    file << "real up" << number << " = wet" << *fluids[f].upstream << " - own" << number << ";\n";
    sums.set(parts + f, parts + *fluids[f].upstream, std::string("up").append(number));
  }
}

}  // namespace

void write_part_terms(DeckFile& file, const FreefemDeck& deck, std::size_t part) {
  const Material& material = deck.spindle.materials[deck.spindle.parts[part].material];
  const auto& pieces = deck.model.section.pieces;
  file << "\n// " << deck.spindle.parts[part].name << "\nmesh Th" << part << " = readmesh(\"part_" << part
       << ".msh\");\nfespace V" << part << "(Th" << part << ", P2);\nV" << part << " T" << part << ";\nvarf k" << part
       << "(u, v) = int2d(Th" << part << ")(ring * (" << material.conductivity_r_W_per_mK << " * dx(u) * dx(v) + "
       << material.conductivity_z_W_per_mK << " * dy(u) * dy(v)))";
  const auto own = [&](std::size_t piece, double coefficient, double radius_shift_m) {
    if (pieces[piece].part != part) return;
    file << "\n  + int1d(Th" << part << ", " << piece + 1 << ")(2 * pi * (x + " << radius_shift_m << ") * "
         << coefficient << " * u * v)";
  };
  for (const DeckFilm& film : deck.model.films) own(film.piece, film.coefficient_W_per_m2K, 0.0);
  for (const DeckPair& pair : deck.model.pairs) {
    if (!pair.matching) continue;
    const double shift_m = 0.5 * offset_of(deck.model, pair).r_m;
    own(pair.piece_a, pair.conductance_W_per_m2K, shift_m);
    own(pair.piece_b, pair.conductance_W_per_m2K, -shift_m);
  }
  file << ";\nmatrix K" << part << " = k" << part << "(V" << part << ", V" << part << ");\nvarf c" << part
       << "(u, v) = int2d(Th" << part << ")(ring * " << material.density_kg_per_m3 * material.heat_capacity_J_per_kgK
       << " * u * v);\nmatrix C" << part << " = c" << part << "(V" << part << ", V" << part << ");\nvarf q" << part
       << "(u, v) = int2d(Th" << part << ")(0. * v)";
  for (const DeckVolumeHeat& heat : deck.model.volume_heats) {
    if (heat.part == part) file << "\n  + int2d(Th" << part << ")(ring * " << heat.density_W_per_m3 << " * v)";
  }
  for (const DeckSurfaceHeat& heat : deck.model.surface_heats) {
    if (pieces[heat.piece].part != part) continue;
    file << "\n  + int1d(Th" << part << ", " << heat.piece + 1 << ")(ring * " << heat.flux_W_per_m2 << " * v)";
  }
  for (const DeckFilm& film : deck.model.films) {
    if (pieces[film.piece].part != part || film.fluid) continue;
    file << "\n  + int1d(Th" << part << ", " << film.piece + 1 << ")(ring * "
         << film.coefficient_W_per_m2K * degC(deck.plan.surrounding_K[film.surrounding]) << " * v)";
  }
  file << ";\nreal[int] Q" << part << " = q" << part << "(0, V" << part << ");\n";
}

Blocks write_coupling(DeckFile& file, const FreefemDeck& deck) {
  BlockSums sums(file);
  for (std::size_t part = 0; part < deck.spindle.parts.size(); ++part) {
    sums.set(part, part, std::string("K").append(std::to_string(part)));
  }
  write_matching_pairs(file, deck, sums);
  write_other_pairs(file, deck, sums);
  write_fluids(file, deck, sums);
  return sums.blocks();
}

void write_fluid_report(DeckFile& file, const FreefemDeck& deck, std::size_t fluid) {
  const DeckFluid& data = deck.model.fluids[fluid];
  const std::size_t place = deck.spindle.parts.size() + fluid;
  file << "  {\n    real at = X(first(" << place << ")), heat = -wet" << fluid << " * at;\n";
  for (std::size_t part = 0; part < deck.spindle.parts.size(); ++part) {
    if (wetted_integral(deck, part, fluid).empty()) continue;
    file << "    heat -= " << wetted_name(part, fluid) << "' * T" << part << "[];\n";
  }
  file << "    cout << state << \" " << (data.circuit ? "liquid " : "air ") << data.name
       << " \" << at << \" \" << heat << endl;\n  }\n";
}

}  // namespace spindle_twin::fem_offline
