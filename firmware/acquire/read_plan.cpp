#include "firmware/acquire/read_plan.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace spindle_twin::firmware {

std::vector<ReadRequest> plan_requests(const std::vector<RegisterSource>& channels) {
  constexpr int most_registers = 125;
  std::vector<std::size_t> order(channels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(channels[a].table, channels[a].address) < std::tuple(channels[b].table, channels[b].address);
  });
  std::vector<ReadRequest> requests;
  for (const std::size_t channel : order) {
    const RegisterSource& source = channels[channel];
    const int end = source.address + words_of(source.type);
    if (!requests.empty()) {
      ReadRequest& last = requests.back();
      const bool touches = last.table == source.table && source.address <= last.address + last.count;
      if (touches && end - last.address <= most_registers) {
        last.count = static_cast<std::uint16_t>(std::max<int>(last.count, end - last.address));
        last.channels.push_back(channel);
        continue;
      }
    }
    requests.push_back({source.table, source.address, static_cast<std::uint16_t>(end - source.address), {channel}});
  }
  return requests;
}

}  // namespace spindle_twin::firmware
