#pragma once

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "fem_offline/model/affine_model.hpp"

/// A made-up spindle on a ring grid of finite volumes (5 mm cells, 1273 unknowns): shaft, rotor, two bearings, stator
/// and housing, with contacts, a gap film, a well-mixed cavity, coolant, ambient and bore films, four heat sources,
/// three key points and a nose row. Everything the reduction asks of an FE model, without the FE library.
namespace spindle_twin::fem_offline {

class GridModelBuilder {
 public:
  AffineModel build() {
    place_cells();
    add_boundaries();
    add_faces();
    add_sources_and_outputs();
    finish();
    return model_;
  }

 private:
  static constexpr int columns = 24;  // in r
  static constexpr int rows = 60;     // in z
  static constexpr double h = 5e-3;
  static constexpr double bore = 10e-3;

  struct Block {
    const char* name;
    int i0, i1, j0, j1;
    double conductivity, heat_capacity_per_m3;
  };
  static constexpr std::array<Block, 6> blocks = {{{"shaft", 0, 8, 0, 60, 48.0, 3.5e6},
                                                   {"front bearing", 8, 14, 2, 8, 44.0, 3.6e6},
                                                   {"rear bearing", 8, 14, 48, 54, 44.0, 3.6e6},
                                                   {"rotor", 8, 11, 15, 35, 30.0, 3.5e6},
                                                   {"stator", 11, 14, 15, 35, 15.0, 3.4e6},
                                                   {"housing", 14, 24, 0, 60, 48.0, 3.5e6}}};

  int cell(int i, int j) const {
    if (i < 0 || i >= columns || j < 0 || j >= rows) return -1;
    return cells_[static_cast<std::size_t>(i * rows + j)];
  }
  int part(int unknown) const { return model_.places[static_cast<std::size_t>(unknown)].part; }
  double radius(int i) const { return bore + (i + 0.5) * h; }
  double volume(int i) const { return 2.0 * std::numbers::pi * radius(i) * h * h; }

  void place_cells() {
    cells_.assign(static_cast<std::size_t>(columns * rows), -1);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      model_.parts.push_back({blocks[b].name, {}, {}, {}});
      for (int i = blocks[b].i0; i < blocks[b].i1; ++i) {
        for (int j = blocks[b].j0; j < blocks[b].j1; ++j) {
          const int unknown = static_cast<int>(model_.places.size());
          cells_[static_cast<std::size_t>(i * rows + j)] = unknown;
          model_.places.push_back({static_cast<int>(b), radius(i), (j + 0.5) * h});
          model_.parts[b].dofs.push_back(unknown);
          capacity_.emplace_back(unknown, unknown, blocks[b].heat_capacity_per_m3 * volume(i));
          volumes_.push_back(volume(i));
        }
      }
    }
    air_ = static_cast<int>(model_.places.size());
    model_.places.push_back({});
    model_.air_names = {"cavity"};
    capacity_.emplace_back(air_, air_, 0.35);
  }

  int add_conductance(const std::string& name, rom::ConductanceKind kind, double nominal, int environment,
                      const rom::SpeedLaw& law = {}) {
    rom::Conductance item;
    item.name = name;
    item.kind = kind;
    item.nominal_W_per_m2K = nominal;
    item.environment = environment;
    item.law = law;
    model_.boundaries.conductances.push_back(item);
    terms_.emplace_back();
    return static_cast<int>(terms_.size()) - 1;
  }

  void add_boundaries() {
    using Kind = rom::ConductanceKind;
    rom::Boundaries& b = model_.boundaries;
    b.reference_speed_rpm = 6000.0;
    b.reference_temperature_K = 300.15;
    b.environments = {{"ambient", rom::EnvironmentKind::ambient}, {"coolant", rom::EnvironmentKind::coolant}};
    b.operating = {6000.0, 1.0, Eigen::VectorXd::Constant(2, 300.15)};
    contacts_[{0, 1}] = add_conductance("shaft-front bearing", Kind::contact, 8000.0, -1);
    contacts_[{0, 2}] = add_conductance("shaft-rear bearing", Kind::contact, 6000.0, -1);
    contacts_[{0, 3}] = add_conductance("shaft-rotor", Kind::contact, 7000.0, -1);
    contacts_[{1, 5}] = add_conductance("front bearing-housing", Kind::contact, 3000.0, -1);
    contacts_[{2, 5}] = add_conductance("rear bearing-housing", Kind::contact, 2500.0, -1);
    contacts_[{4, 5}] = add_conductance("stator-housing", Kind::contact, 3500.0, -1);
    contacts_[{3, 4}] = add_conductance("gap", Kind::gap_film, 400.0, -1, {0.35, {{0.65, 0.6}}, 0.0, false});
    cavity_ = add_conductance("cavity", Kind::air_film, 22.0, -1, {0.3, {{0.7, 0.7}}, 0.0, false});
    coolant_ = add_conductance("coolant", Kind::environment_film, 500.0, 1);
    still_ = add_conductance("still outer faces", Kind::environment_film, 8.0, 0);
    rotating_ = add_conductance("rotating faces", Kind::environment_film, 45.0, 0, {0.2, {{0.8, 0.7}}, 0.0, false});
    bore_film_ = add_conductance("bore", Kind::environment_film, 235.0, 0, {0.6, {{0.4, 0.5}}, 0.0, false});
  }

  static void couple(std::vector<Eigen::Triplet<double>>& term, int a, int b, double value) {
    term.emplace_back(a, a, value);
    term.emplace_back(b, b, value);
    term.emplace_back(a, b, -value);
    term.emplace_back(b, a, -value);
  }

  void add_face(int a, int b, double area, bool outside_bore, bool coolant_band) {
    if (a < 0) std::swap(a, b);
    if (a < 0) return;
    if (b >= 0 && part(a) == part(b)) {
      couple(conduction_, a, b, blocks[static_cast<std::size_t>(part(a))].conductivity * area / h);
    } else if (b >= 0) {
      const int term = contacts_.at({std::min(part(a), part(b)), std::max(part(a), part(b))});
      couple(terms_[static_cast<std::size_t>(term)], a, b, area);
      model_.boundaries.conductances[static_cast<std::size_t>(term)].area_m2 += area;
    } else {
      const int film = outside_bore ? bore_film_ : coolant_band ? coolant_ : part(a) == 0 ? rotating_ : still_;
      terms_[static_cast<std::size_t>(film)].emplace_back(a, a, area);
      model_.boundaries.conductances[static_cast<std::size_t>(film)].area_m2 += area;
    }
  }

  void add_inner_face(int a, int b, double area) {
    if ((a < 0) != (b < 0)) {
      couple(terms_[static_cast<std::size_t>(cavity_)], a < 0 ? b : a, air_, area);
      model_.boundaries.conductances[static_cast<std::size_t>(cavity_)].area_m2 += area;
    } else {
      add_face(a, b, area, false, false);
    }
  }

  void add_faces() {
    using std::numbers::pi;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i <= columns; ++i) {
        const double area = 2.0 * pi * (bore + i * h) * h;
        if (i == 0 || i == columns) {
          add_face(cell(i - 1, j), cell(i, j), area, i == 0, i == columns && j >= 15 && j < 40);
        } else {
          add_inner_face(cell(i - 1, j), cell(i, j), area);
        }
      }
    }
    for (int i = 0; i < columns; ++i) {
      const double area = 2.0 * pi * radius(i) * h;
      for (int j = 0; j <= rows; ++j) {
        if (j == 0 || j == rows) {
          add_face(cell(i, j - 1), cell(i, j), area, false, false);
        } else {
          add_inner_face(cell(i, j - 1), cell(i, j), area);
        }
      }
    }
  }

  void add_sources_and_outputs() {
    const int unknowns = static_cast<int>(model_.places.size());
    model_.boundaries.sources = {{"front bearing", 55.0, {0.0, {{0.5, 1.0}, {0.5, 5.0 / 3.0}}, 0.0, true}},
                                 {"rear bearing", 25.0, {0.0, {{0.5, 1.0}, {0.5, 5.0 / 3.0}}, 0.0, true}},
                                 {"rotor", 80.0, {0.0, {{0.35, 1.5}}, 0.65, true}},
                                 {"stator", 290.0, {0.0, {{0.5, 1.3}}, 0.5, true}}};
    model_.source_distribution.setZero(unknowns, 4);
    for (std::size_t p = 0; p < model_.parts.size(); ++p) {
      FePart& item = model_.parts[p];
      item.mean_row.setZero(unknowns);
      double total = 0.0;
      for (const int unknown : item.dofs) total += volumes_[static_cast<std::size_t>(unknown)];
      for (const int unknown : item.dofs) {
        item.mean_row[unknown] = volumes_[static_cast<std::size_t>(unknown)] / total;
      }
      if (p >= 1 && p <= 4) model_.source_distribution.col(static_cast<Eigen::Index>(p) - 1) = item.mean_row;
    }
    add_key_point("inner", 2, cell(8, 51), cell(9, 51));
    add_key_point("outer", 2, cell(13, 51), cell(13, 52));
    add_key_point("front", 1, cell(10, 4), cell(10, 5));
    FeDeformation nose{"nose", Eigen::VectorXd::Zero(unknowns)};
    for (const int unknown : model_.parts[0].dofs) {
      if (model_.places[static_cast<std::size_t>(unknown)].z_m < 0.15) nose.row_m_per_K[unknown] = 1.17e-5 * 0.15;
    }
    nose.row_m_per_K.array() *= model_.parts[0].mean_row.array() * 2.0;
    for (const int unknown : model_.parts[5].dofs) {
      nose.row_m_per_K[unknown] = 1.17e-5 * 0.08 * model_.parts[5].mean_row[unknown];
    }
    model_.deformations = {nose};
  }

  void add_key_point(const char* name, int part_index, int a, int b) {
    FeKeyPoint point{name, part_index, {}, Eigen::SparseVector<double>(static_cast<int>(model_.places.size()))};
    point.row.coeffRef(a) = 0.5;
    point.row.coeffRef(b) = 0.5;
    point.at = {model_.places[static_cast<std::size_t>(a)].r_m, model_.places[static_cast<std::size_t>(a)].z_m};
    model_.key_points.push_back(point);
  }

  void finish() {
    const int unknowns = static_cast<int>(model_.places.size());
    const auto matrix = [unknowns](const std::vector<Eigen::Triplet<double>>& entries) {
      SparseMatrix result(unknowns, unknowns);
      result.setFromTriplets(entries.begin(), entries.end());
      return result;
    };
    model_.capacity_J_per_K = matrix(capacity_);
    model_.conduction_W_per_K = matrix(conduction_);
    for (const auto& term : terms_) model_.conductance_terms_m2.push_back(matrix(term));
    model_.spindle = "grid";
    model_.description_hash = std::string(64, '0');
  }

  AffineModel model_;
  std::vector<int> cells_;
  std::vector<double> volumes_;
  std::vector<Eigen::Triplet<double>> capacity_, conduction_;
  std::vector<std::vector<Eigen::Triplet<double>>> terms_;
  std::map<std::pair<int, int>, int> contacts_;
  int air_ = 0, cavity_ = 0, coolant_ = 0, still_ = 0, rotating_ = 0, bore_film_ = 0;
};

inline AffineModel make_grid_model() { return GridModelBuilder().build(); }

}  // namespace spindle_twin::fem_offline
