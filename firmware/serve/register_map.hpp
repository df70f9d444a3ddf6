#pragma once

#include <array>
#include <cstdint>

#include "firmware/serve/register_table.hpp"

namespace spindle_twin::firmware {

/// registers.md and registers.csv as they stand beside registers.toml.
const char* register_map_markdown();
const char* register_map_csv();

/// One past the last offset of the map.
constexpr std::size_t image_size() {
  std::size_t end = 0;
  for (const RegisterBlock& block : register_blocks) {
    const std::size_t block_end = std::size_t{block.address} + block.length;
    end = end > block_end ? end : block_end;
  }
  return end;
}

/// All registers by 0-based offset; offsets that the map does not use hold 0.
using RegisterImage = std::array<std::uint16_t, image_size()>;

constexpr const RegisterEntry& entry_of(Register which) { return register_entries[static_cast<std::size_t>(which)]; }

/// The block that the PLC writes.
constexpr const RegisterBlock& command_block() {
  for (const RegisterBlock& block : register_blocks) {
    if (block.command) return block;
  }
  return register_blocks.back();
}

}  // namespace spindle_twin::firmware
