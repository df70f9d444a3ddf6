#pragma once

namespace spindle_twin::rom::tests {

/// Heap allocations (malloc, calloc, realloc, aligned ones, operator new) of this thread since the program began,
/// those inside shared libraries included. The program's malloc is replaced for this; under a sanitizer its own hook
/// counts.
long heap_calls();

}  // namespace spindle_twin::rom::tests
