#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// The folder of binaries/ that this program's runtime belongs to, "linux64" on x86-64.
const char* fmu_platform();

/// An FMU (FMI 2.0, co-simulation) at `path`: modelDescription.xml, resources/network.rom with the bytes `rom_file`,
/// and the runtime as binaries/<platform>/spindle_twin.so, which this program carries in itself, so that no compiler is
/// needed. The same input gives the same bytes. Throws rom::InputError if the file cannot be written.
void write_fmu(const rom::Network& network, std::span<const std::uint8_t> rom_file, const std::string& path);

/// modelDescription.xml of the same.
std::string fmu_model_description(const rom::Network& network, const std::string& guid);

}  // namespace spindle_twin::host_tools
