#include "fem_offline/exchange_files/freefem_deck.hpp"

#include <cmath>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/deck_files.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

struct Edge {
  std::size_t a, b, label;
};

/// Border labels are numbers of pieces plus 1, regions are numbers of parts plus 1.
void write_msh(const std::string& directory, const std::string& name, const DeckModel& deck,
               const std::vector<std::size_t>& elements, const std::vector<Edge>& edges,
               const std::vector<std::size_t>& leader) {
  std::map<std::size_t, std::size_t> number;
  std::vector<std::size_t> order;
  const auto numbered = [&](std::size_t node) {
    const auto [found, added] = number.emplace(leader[node], order.size() + 1);
    if (added) order.push_back(leader[node]);
    return found->second;
  };
  std::ostringstream triangles, borders;
  for (const std::size_t e : elements) {
    const auto& nodes = deck.elements[e];
    const std::size_t a = numbered(nodes[0]), b = numbered(nodes[1]), c = numbered(nodes[2]), d = numbered(nodes[3]);
    const std::size_t region = deck.part_of_element[e] + 1;
    triangles << a << " " << b << " " << c << " " << region << "\n"
              << a << " " << c << " " << d << " " << region << "\n";
  }
  for (const Edge& edge : edges) borders << numbered(edge.a) << " " << numbered(edge.b) << " " << edge.label << "\n";
  DeckFile file(directory, name);
  file << order.size() << " " << 2 * elements.size() << " " << edges.size() << "\n";
  for (const std::size_t node : order) file << deck.nodes[node].r_m << " " << deck.nodes[node].z_m << " 0\n";
  file << triangles.str() << borders.str();
  file.close();
}

std::vector<Edge> edges_of(const DeckModel& deck, std::size_t piece) {
  std::vector<Edge> edges;
  for (const DeckSide& side : deck.sides_of_piece[piece]) {
    const auto [a, b, middle] = nodes_of(deck, side);
    edges.push_back({a, b, piece + 1});
  }
  return edges;
}

std::vector<std::size_t> pieces_in(const DeckModel& deck, std::size_t part, const Box& face) {
  std::vector<std::size_t> found;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    if (deck.section.pieces[p].part == part && lies_in(deck.section.pieces[p], face)) found.push_back(p);
  }
  return found;
}

void write_meshes(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  std::vector<std::size_t> itself(deck.nodes.size());
  for (std::size_t i = 0; i < itself.size(); ++i) itself[i] = i;
  std::vector<std::size_t> all;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    std::vector<std::size_t> elements;
    for (std::size_t e = 0; e < deck.elements.size(); ++e) {
      if (deck.part_of_element[e] == part) elements.push_back(e);
    }
    all.insert(all.end(), elements.begin(), elements.end());
    std::vector<Edge> edges;
    for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
      if (deck.section.pieces[p].part != part) continue;
      for (const Edge& edge : edges_of(deck, p)) edges.push_back(edge);
    }
    write_msh(directory, "part_" + std::to_string(part) + ".msh", deck, elements, edges, itself);
  }
  if (deck.deformations.empty()) return;
  std::set<std::size_t> wanted;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    if (deck.section.pieces[p].kind != PieceKind::contact) wanted.insert(p);
  }
  for (const Support& support : spindle.supports) {
    for (const std::size_t p : pieces_in(deck, support.part, support.face)) wanted.insert(p);
  }
  for (const DeformationOutput& output : spindle.deformations) {
    for (const std::size_t p : pieces_in(deck, output.part, output.face)) wanted.insert(p);
  }
  std::vector<Edge> edges;
  for (const std::size_t p : wanted) {
    for (const Edge& edge : edges_of(deck, p)) edges.push_back(edge);
  }
  write_msh(directory, "bonded.msh", deck, all, edges, bonded_leaders(deck));
}

/// How the face of the other side is reached: along the normal, by (r, z).
Point offset_of(const DeckModel& deck, const DeckPair& pair) {
  const BoundaryPiece& a = deck.section.pieces[pair.piece_a];
  const BoundaryPiece& b = deck.section.pieces[pair.piece_b];
  const double length_m = std::hypot(a.end.r_m - a.start.r_m, a.end.z_m - a.start.z_m);
  const double normal_r = (a.end.z_m - a.start.z_m) / length_m, normal_z = -(a.end.r_m - a.start.r_m) / length_m;
  const double distance_m = (b.start.r_m - a.start.r_m) * normal_r + (b.start.z_m - a.start.z_m) * normal_z;
  return {distance_m * normal_r, distance_m * normal_z};
}

/// FreeFEM's integral across two meshes gives wrong rises, by kelvins, where the nodes of both sides differ.
void refuse_contacts_that_do_not_match(const Spindle& spindle, const DeckModel& deck) {
  for (const DeckPair& pair : deck.pairs) {
    if (pair.kind != PieceKind::contact || pair.matching) continue;
    const Contact& contact = spindle.contacts[pair.index];
    throw rom::InputError(contact.where, "contact",
                          "cannot be exported to FreeFEM: the meshes of '" + spindle.parts[contact.part_a].name +
                              "' and '" + spindle.parts[contact.part_b].name + "' do not match; CalculiX takes it");
  }
}

struct Deck {
  const Spindle& spindle;
  const DeckModel& model;
  const DeckPlan& plan;
  std::vector<std::size_t> airs;  ///< surroundings
};

bool is_air(const Deck& deck, const DeckFilm& film) {
  return deck.spindle.surroundings[film.surrounding].kind == SurroundingKind::air;
}

void write_part_terms(DeckFile& file, const Deck& deck, std::size_t part) {
  const Material& material = deck.spindle.materials[deck.spindle.parts[part].material];
  const auto& pieces = deck.model.section.pieces;
  file << "\n// " << deck.spindle.parts[part].name << "\nmesh Th" << part << " = readmesh(\"part_" << part
       << ".msh\");\nfespace V" << part << "(Th" << part << ", P2);\nV" << part << " T" << part << ";\nvarf k" << part
       << "(u, v) = int2d(Th" << part << ")(ring * (" << material.conductivity_r_W_per_mK << " * dx(u) * dx(v) + "
       << material.conductivity_z_W_per_mK << " * dy(u) * dy(v)))";
  const auto own = [&](std::size_t piece, double coefficient, double radius_shift_m) {
    file << "\n  + int1d(Th" << part << ", " << piece + 1 << ")(2 * pi * (x + " << radius_shift_m << ") * "
         << coefficient << " * u * v)";
  };
  for (const DeckFilm& film : deck.model.films) {
    if (pieces[film.piece].part == part) own(film.piece, film.coefficient_W_per_m2K, 0.0);
  }
  for (const DeckPair& pair : deck.model.pairs) {
    const double shift_m = 0.5 * offset_of(deck.model, pair).r_m;
    if (pieces[pair.piece_a].part == part) own(pair.piece_a, pair.conductance_W_per_m2K, shift_m);
    if (pieces[pair.piece_b].part == part) own(pair.piece_b, pair.conductance_W_per_m2K, -shift_m);
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
    if (pieces[film.piece].part != part || is_air(deck, film)) continue;
    file << "\n  + int1d(Th" << part << ", " << film.piece + 1 << ")(ring * "
         << film.coefficient_W_per_m2K * degC(deck.plan.surrounding_K[film.surrounding]) << " * v)";
  }
  file << ";\nreal[int] Q" << part << " = q" << part << "(0, V" << part << ");\n";
}

using Blocks = std::map<std::pair<std::size_t, std::size_t>, std::string>;

/// Matrices between the unknowns of different parts, and between parts and air volumes.
Blocks write_coupling(DeckFile& file, const Deck& deck) {
  const std::size_t parts = deck.spindle.parts.size();
  Blocks blocks;
  for (std::size_t part = 0; part < parts; ++part) blocks[{part, part}] = std::string("K").append(std::to_string(part));
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::string>> terms;
  const auto& pieces = deck.model.section.pieces;
  for (const DeckPair& pair : deck.model.pairs) {
    const std::size_t a = pieces[pair.piece_a].part, b = pieces[pair.piece_b].part;
    const Point offset = offset_of(deck.model, pair);
    std::ostringstream term;
    term << std::setprecision(12) << std::showpoint;
    term << "int1d(Th" << a << ", " << pair.piece_a + 1;
    if (pair.kind == PieceKind::gap) term << ", mapu = [x + " << offset.r_m << ", y + " << offset.z_m << "]";
    term << ")(-2 * pi * (x + " << 0.5 * offset.r_m << ") * " << pair.conductance_W_per_m2K << " * u * v)";
    terms[{a, b}].push_back(term.str());
  }
  for (const auto& [both, list] : terms) {
    const auto& [a, b] = both;
    const std::string name = std::to_string(a) + "x" + std::to_string(b);
    file << "varf m" << name << "(u, v) = ";
    for (std::size_t i = 0; i < list.size(); ++i) file << (i > 0 ? "\n  + " : "") << list[i];
    file << ";\nmatrix M" << name << " = m" << name << "(V" << b << ", V" << a << ");\n";
    // Both orders of a pair of parts may occur, as in a contact and a gap between the same two.
    const auto add = [&](std::size_t row, std::size_t column, const std::string& matrix) {
      std::string& block = blocks[{row, column}];
      if (!block.empty()) {
        const std::string sum = std::string("S").append(std::to_string(row)).append("x").append(std::to_string(column));
        file << "matrix " << sum << " = " << block << " + " << matrix << ";\n";
        block = sum;
      } else {
        block = matrix;
      }
    };
    file << "matrix N" << name << " = M" << name << "';\n";
    add(a, b, "M" + name);
    add(b, a, "N" + name);
  }
  for (std::size_t v = 0; v < deck.airs.size(); ++v) {
    file << "real wet" << v << " = 0;\n";
    for (std::size_t part = 0; part < parts; ++part) {
      std::ostringstream integral;
      integral << std::setprecision(12) << std::showpoint;
      for (const DeckFilm& film : deck.model.films) {
        if (film.surrounding != deck.airs[v] || pieces[film.piece].part != part) continue;
        integral << (integral.tellp() > 0 ? " + " : "") << "int1d(Th" << part << ", " << film.piece + 1 << ")(-ring * "
                 << film.coefficient_W_per_m2K << " * v)";
      }
      if (integral.str().empty()) continue;
      const std::string name = std::to_string(part) + "v" + std::to_string(v);
      file << "varf a" << name << "(u, v) = " << integral.str() << ";\nreal[int] A" << name << " = a" << name << "(0, V"
           << part << ");\nwet" << v << " -= A" << name << ".sum;\n";
      blocks[{part, parts + v}] = "A" + name;
      blocks[{parts + v, part}] = "A" + name + "'";
    }
    blocks[{parts + v, parts + v}] = "wet" + std::to_string(v);
  }
  return blocks;
}

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

void write_elastic(DeckFile& file, const Deck& deck) {
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
  file << held.str() << ";\nmatrix E = elastic(W, W);\nset(E, solver = sparsesolver);\n"
       << "varf expansion([u, w], [s, t]) = " << load.str() << held.str() << ";\n";
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
  for (std::size_t v = 0; v < deck.airs.size(); ++v) {
    file << "  cout << state << \" air " << spindle.surroundings[deck.airs[v]].name << " \" << X(first("
         << spindle.parts.size() + v << ")) << endl;\n";
  }
  if (!deck.model.deformations.empty()) {
    file << "  W [u, w];\n  real[int] F = expansion(0, W);\n  u[] = E^-1 * F;\n";
    for (const DeformationOutput& output : spindle.deformations) {
      std::string labels;
      for (const std::size_t p : pieces_in(deck.model, output.part, output.face)) {
        labels += ", " + std::to_string(p + 1);
      }
      file << "  cout << state << \" deformation_um " << output.name << " \" << " << rom::um_per_m * output.sign
           << " * int1d(All" << labels << ")(x * " << (output.direction == Direction::radial ? "u" : "w")
           << ") / int1d(All" << labels << ")(x) << endl;\n";
    }
  }
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
  const std::size_t blocks_in_row = parts + deck.airs.size();
  DeckFile file(directory, "spindle.edp");
  file << "// FreeFEM deck of the spindle '" << deck.spindle.name << "': x = r, y = z, SI, degC.\n"
       << "cout.precision(12);\nmacro ring() (2 * pi * x) //\n";
  for (std::size_t part = 0; part < parts; ++part) write_part_terms(file, deck, part);
  file << "\n// contacts, gaps and air volumes\n";
  const Blocks conduction = write_coupling(file, deck);
  write_block_matrix(file, "K", blocks_in_row, conduction);
  Blocks capacity;
  for (std::size_t part = 0; part < parts; ++part)
    capacity[{part, part}] = std::string("C").append(std::to_string(part));
  for (std::size_t v = 0; v < deck.airs.size(); ++v) {
    std::ostringstream number;
    number << std::setprecision(12) << std::showpoint;
    number << deck.spindle.surroundings[deck.airs[v]].capacity_J_per_K;
    capacity[{parts + v, parts + v}] = number.str();
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
         "minimum).\n";
  if (!deck.growth_left_out.empty()) file << "Without growth: " << deck.growth_left_out << "\n";
  file.close();
}

}  // namespace

void write_freefem_deck(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                        const std::string& directory) {
  refuse_contacts_that_do_not_match(spindle, deck);
  make_deck_folder(directory);
  write_meshes(spindle, deck, directory);
  Deck all{spindle, deck, plan, {}};
  for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
    if (spindle.surroundings[i].kind == SurroundingKind::air) all.airs.push_back(i);
  }
  write_script(all, directory);
  write_freefem_readme(spindle, deck, directory);
}

}  // namespace spindle_twin::fem_offline
