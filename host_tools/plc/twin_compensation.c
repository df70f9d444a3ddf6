#include "twin_compensation.h"

#include <math.h>

/* Is it a spindle-twind, and does its heartbeat move? The first one that is read proves nothing. */
static void watch_heartbeat(struct twin_memory* memory, const struct twin_settings* settings,
                            const struct twin_input* input, uint32_t step_us) {
  const uint16_t heartbeat = input->answer[TWIN_A_HEARTBEAT];
  if (input->head[TWIN_HEAD_KNOWN] != TWIN_KNOWN_ANSWER) {
    memory->known = false;
    memory->alive = false;
  } else if (!memory->known) {
    memory->known = true;
    memory->last_heartbeat = heartbeat;
  } else if (heartbeat != memory->last_heartbeat) {
    memory->last_heartbeat = heartbeat;
    memory->alive = true;
    memory->still_us = 0;
  } else if (memory->alive) {
    memory->still_us += step_us;
    memory->alive = memory->still_us < settings->stale_ms * TWIN_US_PER_MS;
  }
}

/* The first reason not to believe the value. */
static enum twin_reason judge(const struct twin_memory* memory, const struct twin_settings* settings,
                              const struct twin_input* input) {
  const uint16_t* answer = input->answer;
  const uint16_t state = answer[TWIN_A_STATE], rung = answer[TWIN_A_RUNG];
  if (!memory->known) return TWIN_REASON_NO_TWIN;
  if (input->head[TWIN_HEAD_MAP] != TWIN_MAP_VERSION) return TWIN_REASON_MAP;
  if (!memory->alive) return TWIN_REASON_STALE;
  if (state != TWIN_STATE_RUNNING && state != TWIN_STATE_DEGRADED) return TWIN_REASON_STATE;
  if (rung == TWIN_RUNG_NONE || rung > TWIN_RUNG_LAST) return TWIN_REASON_NO_PREDICTION;
  if (answer[TWIN_A_VALUE] == TWIN_VALUE_NOT_PRESENT) return TWIN_REASON_NOT_PRESENT;
  if (answer[TWIN_A_AGE] > settings->age_s) return TWIN_REASON_OLD;
  if ((answer[TWIN_A_QUALITY] & settings->quality_stop) != TWIN_NO_BITS) return TWIN_REASON_QUALITY;
  if ((answer[TWIN_A_FAULT] & settings->fault_stop) != TWIN_NO_BITS) return TWIN_REASON_FAULT;
  return TWIN_REASON_OK;
}

/* What is no longer valid stays for hold_ms. */
static void hold(struct twin_compensation* twin, const struct twin_settings* settings, const struct twin_input* input,
                 uint32_t step_us) {
  struct twin_memory* memory = &twin->memory;
  const int32_t word = input->answer[TWIN_A_VALUE];
  const uint32_t hold_us = settings->hold_ms * TWIN_US_PER_MS;
  if (twin->output.valid) {
    memory->held_nm = (word > INT16_MAX ? word - UINT16_MAX - 1 : word) * TWIN_NM_PER_COUNT;
    memory->held_us = 0;
  } else if (memory->held_us < hold_us) {
    memory->held_us += step_us;
  }
  twin->output.lost = !twin->output.valid && memory->held_us >= hold_us;
}

/* Whole nanometres in steps of 10 ms: a float would swallow the small steps of a fast control. */
static void move(struct twin_compensation* twin, int32_t target_nm, int32_t rate_nm_per_s, uint32_t step_us) {
  const uint32_t us = twin->memory.move_us + step_us;
  const int32_t most_nm = (int32_t)(us / TWIN_TICK_US) * (rate_nm_per_s / TWIN_TICKS_PER_S);
  int32_t* value_nm = &twin->output.value_nm;
  twin->memory.move_us = us % TWIN_TICK_US;
  if (target_nm > *value_nm + most_nm) {
    *value_nm += most_nm;
  } else if (target_nm < *value_nm - most_nm) {
    *value_nm -= most_nm;
  } else {
    *value_nm = target_nm;
  }
}

void twin_step(struct twin_compensation* twin, const struct twin_settings* settings, const struct twin_input* input) {
  struct twin_output* output = &twin->output;
  const uint32_t step_us = input->elapsed_us > TWIN_MOST_STEP_US ? TWIN_MOST_STEP_US : input->elapsed_us;
  output->valid = output->settled = output->limited = false;
  if (!twin_settings_good(settings)) {
    output->reason = TWIN_REASON_SETTING;
    twin->memory.known = twin->memory.alive = false;
    return;
  }
  watch_heartbeat(&twin->memory, settings, input, step_us);
  output->reason = (uint16_t)judge(&twin->memory, settings, input);
  output->valid = output->reason == TWIN_REASON_OK;
  hold(twin, settings, input, step_us);
  int32_t target_nm = twin->memory.held_nm;
  if (target_nm > settings->limit_nm || target_nm < -settings->limit_nm) {
    target_nm = target_nm > 0 ? settings->limit_nm : -settings->limit_nm;
    output->limited = output->valid;
  }
  if (!input->enable || output->lost) target_nm = 0;
  if (input->ready) {
    const bool returns = input->enable && output->lost;
    move(twin, target_nm, returns ? settings->return_nm_per_s : settings->slew_nm_per_s, step_us);
  }
  output->settled = output->valid && input->enable && !output->limited && output->value_nm == target_nm;
  output->output = (float)output->value_nm * TWIN_UM_PER_NM * settings->scale;
  output->counts = (int32_t)lrintf(output->output);
}
