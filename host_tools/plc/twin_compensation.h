/* What a control adds to its axis, from the registers of spindle-twind: believed, limited and moved without a step. The
 * same logic as spindle_twin.st, for controls that are programmed in C. C99 with lrintf of its
 * library; no operating system, no heap. */
#ifndef SPINDLE_TWIN_COMPENSATION_H
#define SPINDLE_TWIN_COMPENSATION_H

#include "twin_interface.h"

struct twin_compensation { /* all zero before the first step */
  struct twin_memory memory;
  struct twin_output output;
};

/* One call in each cycle of the control, with the words that were read last, however old: an old heartbeat stands, and
 * that is noticed. Bounded time; may run in the control's cycle. */
void twin_step(struct twin_compensation* twin, const struct twin_settings* settings, const struct twin_input* input);

#endif
