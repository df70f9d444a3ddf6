/* Made by host_tools/plc/generate_plc.py; do not edit. */
#ifndef SPINDLE_TWIN_INTERFACE_H
#define SPINDLE_TWIN_INTERFACE_H

#include <stdbool.h>
#include <stdint.h>

#define TWIN_HEAD_ADDRESS 0 /* first input register (FC4) of head */
#define TWIN_HEAD_COUNT 7
#define TWIN_ANSWER_ADDRESS 1502 /* first input register (FC4) of answer */
#define TWIN_ANSWER_COUNT 14
#define TWIN_KNOWN_ANSWER 4660u
#define TWIN_MAP_VERSION 2u
#define TWIN_STATE_RUNNING 1u
#define TWIN_STATE_DEGRADED 2u
#define TWIN_RUNG_NONE 0u
#define TWIN_RUNG_LAST 5u
#define TWIN_VALUE_NOT_PRESENT 32768u
#define TWIN_NM_PER_COUNT 100
#define TWIN_MOST_STEP_US 1000000u
#define TWIN_US_PER_MS 1000u
#define TWIN_TICK_US 10000u
#define TWIN_TICKS_PER_S 100
#define TWIN_UM_PER_NM 0.001f
#define TWIN_NO_BITS 0u
#define TWIN_HEAD_KNOWN 0
#define TWIN_HEAD_MAP 6
#define TWIN_A_HEARTBEAT 0
#define TWIN_A_STATE 1
#define TWIN_A_QUALITY 2
#define TWIN_A_FAULT 3
#define TWIN_A_RUNG 4
#define TWIN_A_VALUE 12
#define TWIN_A_AGE 13

/* The first that applies is told. */
enum twin_reason {
  TWIN_REASON_OK = 0, /* the value is valid */
  TWIN_REASON_SETTING = 1, /* a setting is outside its range; the value stays where it is until that is mended */
  TWIN_REASON_NO_TWIN = 2, /* the known answer is wrong: nothing read yet, another device, or bytes swapped */
  TWIN_REASON_MAP = 3, /* registers of another version than these files are for */
  TWIN_REASON_STALE = 4, /* the heartbeat stands, or has not been seen to move yet: no connection, or the daemon hangs */
  TWIN_REASON_STATE = 5, /* the daemon is neither running nor degraded */
  TWIN_REASON_NO_PREDICTION = 6, /* compensation_rung is none, or one that this map does not have */
  TWIN_REASON_NOT_PRESENT = 7, /* compensation_int16 has no value */
  TWIN_REASON_OLD = 8, /* the daemon's last prediction is older than AgeS */
  TWIN_REASON_QUALITY = 9, /* a bit of QualityStop is up */
  TWIN_REASON_FAULT = 10, /* a bit of FaultStop is up */
};
#define TWIN_REASON_NAMES {"ok", "setting", "no_twin", "map", "stale", "state", "no_prediction", "not_present", "old", "quality", "fault"}

/* What is set once, at commissioning. */
struct twin_settings {
  int32_t limit_nm; /* nm: the value stays within plus and minus this */
  int32_t slew_nm_per_s; /* nm/s: the value moves no faster, in steps of 10 ms; multiples of 100 */
  int32_t return_nm_per_s; /* nm/s: the same on the way to zero after HoldMs; multiples of 100 */
  uint32_t stale_ms; /* ms: a heartbeat that stands for so long is a lost connection */
  uint32_t hold_ms; /* ms: so long a value that is no longer valid stays; then it goes to zero */
  uint16_t age_s; /* s: a value is taken while the daemon's last prediction is no older */
  uint16_t quality_stop; /* bits of compensation_quality that make the value invalid; the daemon judges them itself, so none */
  uint16_t fault_stop; /* bits of compensation_fault that do; likewise */
  float scale; /* 1/um: the control's units in a micrometre, negative where the control's + is the other way */
};

#define TWIN_SETTINGS_DEFAULT {200000, 10000, 100, 3000u, 600000u, 600u, 0u, 0u, 1.0f}

/* What each call takes. */
struct twin_input {
  uint16_t head[7]; /* words of the read at the beginning of the map: is it a spindle-twind, and one of this map? */
  uint16_t answer[14]; /* words of the read of the compensation, all of one cycle of the daemon */
  uint32_t elapsed_us; /* us: time since the call before; the period of the task. More than 1 s counts as 1 s */
  bool enable; /* FALSE: the value goes to zero at SlewNmPerS */
  bool ready; /* the control takes the value: its axis is referenced. FALSE: the value stays where it is */
};

/* What each call gives. */
struct twin_output {
  float output; /* the value in the control's units */
  int32_t counts; /* the same as the nearest whole number */
  int32_t value_nm; /* nm: the value; + = spindle longer while compensation.sign of the daemon is 1 */
  bool valid; /* the daemon's value is there, fresh and meant to be used */
  bool settled; /* valid, and the value stands where the daemon wants it. Do not cut to size before */
  bool limited; /* valid, but beyond LimitNm */
  bool lost; /* no valid value for HoldMs: the value goes to zero, or is there */
  uint16_t reason; /* why it is not valid, 0 = it is */
};

/* What is remembered between two calls; zero before the first. */
struct twin_memory {
  int32_t held_nm; /* the last valid value */
  uint32_t held_us; /* time since it was valid */
  uint32_t still_us; /* time since the heartbeat moved */
  uint32_t move_us; /* time not yet used for a step */
  uint16_t last_heartbeat; /* of the call before */
  bool known; /* LastHeartbeat was read from a daemon */
  bool alive; /* the heartbeat moves */
};

/* Whether each setting is within its range; not a number is not. */
static inline bool twin_settings_good(const struct twin_settings* settings) {
  return settings->limit_nm >= 0 &&
         settings->limit_nm <= 3000000 &&
         settings->slew_nm_per_s >= 100 &&
         settings->slew_nm_per_s <= 1000000 &&
         settings->return_nm_per_s >= 100 &&
         settings->return_nm_per_s <= 1000000 &&
         settings->stale_ms >= 1u &&
         settings->stale_ms <= 3600000u &&
         settings->hold_ms <= 3600000u &&
         settings->age_s <= 65534u &&
         settings->scale >= -10000.0f &&
         settings->scale <= 10000.0f;
}

#endif
