#include "fem_offline/exchange_files/calculix_outputs.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "fem_offline/exchange_files/calculix_run.hpp"
#include "fem_offline/exchange_files/deck_files.hpp"

namespace spindle_twin::fem_offline {
namespace {

nlohmann::json as_json(const DeckRow& row) {
  nlohmann::json entries = nlohmann::json::array();
  for (const auto& [node, weight] : row) entries.push_back({node + 1, weight});
  return entries;
}

/// [first node, second node, midside, their radii, length, coefficient] of each wetted side.
nlohmann::json wetted_sides(const DeckModel& deck, std::size_t fluid) {
  nlohmann::json sides = nlohmann::json::array();
  for (const DeckFilm& film : deck.films) {
    if (film.fluid != fluid) continue;
    for (const DeckSide& side : deck.sides_of_piece[film.piece]) {
      const auto [a, b, middle] = nodes_of(deck, side);
      const Point &from = deck.nodes[a], &to = deck.nodes[b];
      sides.push_back({a + 1, b + 1, middle + 1, from.r_m, to.r_m, std::hypot(to.r_m - from.r_m, to.z_m - from.z_m),
                       film.coefficient_W_per_m2K});
    }
  }
  return sides;
}

nlohmann::ordered_json fluids_json(const Spindle& spindle, const DeckModel& deck, const FluidHistory& history) {
  nlohmann::ordered_json fluids = nlohmann::ordered_json::object();
  for (std::size_t f = 0; f < deck.fluids.size(); ++f) {
    const DeckFluid& fluid = deck.fluids[f];
    nlohmann::ordered_json& entry = fluids[fluid.name];
    entry["steady_degC"] = degC(history.steady_K[f]);
    if (fluid.circuit) {
      entry["circuit"] = spindle.circuits[*fluid.circuit].name;
      entry["flow_W_per_K"] = fluid.flow_W_per_K;
      if (fluid.upstream) entry["upstream"] = deck.fluids[*fluid.upstream].name;
    }
    entry["sides"] = wetted_sides(deck, f);
  }
  return fluids;
}

nlohmann::ordered_json deformations_json(const Spindle& spindle, const DeckModel& deck) {
  nlohmann::ordered_json outputs = nlohmann::ordered_json::object();
  for (std::size_t d = 0; d < deck.deformations.size(); ++d) {
    const DeformationOutput& output = spindle.deformations[d];
    outputs[output.name] = {{"direction", output.direction == Direction::radial ? 1 : 2},
                            {"nodes", as_json(deck.deformations[d])}};
    if (output.minus) outputs[output.name]["minus"] = spindle.deformations[*output.minus].name;
  }
  return outputs;
}

}  // namespace

void write_calculix_outputs(const Spindle& spindle, const DeckModel& deck, const DeckPlan& plan,
                            const FluidHistory& history, const std::string& directory) {
  nlohmann::ordered_json outputs;
  outputs["reference_temperature_degC"] = degC(spindle.operating.reference_temperature_K);
  outputs["start_degC"] = degC(plan.start_K);
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    nlohmann::ordered_json nodes = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < deck.nodes.size(); ++i) {
      if (deck.part_of_node[i] == part) nodes.push_back(i + 1);
    }
    outputs["parts"][spindle.parts[part].name] = std::move(nodes);
  }
  outputs["key_points"] = nlohmann::ordered_json::object();
  for (std::size_t k = 0; k < deck.key_points.size(); ++k) {
    outputs["key_points"][spindle.key_points[k].name] = as_json(deck.key_points[k]);
  }
  if (!deck.growth_left_out.empty()) outputs["growth_left_out"] = deck.growth_left_out;
  outputs["deformations"] = deformations_json(spindle, deck);
  nlohmann::ordered_json increments = nlohmann::ordered_json::array();
  double from_s = 0.0;
  for (const TimeStage& stage : time_stages(plan)) {
    increments.push_back({{"until_s", stage.until_s}, {"count", std::lround((stage.until_s - from_s) / stage.step_s)}});
    from_s = stage.until_s;
  }
  outputs["transient_steps"] = std::move(increments);
  outputs["fluids"] = fluids_json(spindle, deck, history);
  DeckFile file(directory, "outputs.json");
  file << outputs.dump() << "\n";
  file.close();
}

}  // namespace spindle_twin::fem_offline
