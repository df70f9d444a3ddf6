#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>

#include "host_tools/fmu/fmi2.hpp"
#include "host_tools/fmu/instance.hpp"
#include "rom/read/input_error.hpp"

// The C functions that an importer calls. Everything that can go wrong ends in fmi2Error and one message.
using spindle_twin::host_tools::FmuInstance;
using spindle_twin::host_tools::FmuState;

namespace {

struct Slave {
  std::string name;
  fmi2CallbackFunctions callbacks;
  FmuInstance instance;
};

void say(const fmi2CallbackFunctions& callbacks, const char* name, const char* message) {
  if (callbacks.logger != nullptr) {
    callbacks.logger(callbacks.componentEnvironment, name, fmi2Error, "logStatusError", "%s", message);
  }
}

/// work(slave) with every exception as fmi2Error and a message.
template <class Work>
fmi2Status guarded(fmi2Component component, Work work) {
  if (component == nullptr) return fmi2Error;
  Slave& slave = *static_cast<Slave*>(component);
  try {
    work(slave);
    return fmi2OK;
  } catch (const std::exception& error) {
    say(slave.callbacks, slave.name.c_str(), error.what());
  } catch (...) {
    say(slave.callbacks, slave.name.c_str(), "unknown error");
  }
  return fmi2Error;
}

[[noreturn]] void refuse(const char* what, const char* message) {
  throw spindle_twin::rom::InputError({}, what, message);
}

/// There are real variables only.
fmi2Status none_of_this_type(fmi2Component component, std::size_t count) {
  return guarded(component, [&](Slave&) {
    if (count > 0) refuse("value reference", "there are variables of type Real only");
  });
}

fmi2Status no_such_status(fmi2Component component) {
  return guarded(component, [](Slave&) { refuse("status", "no step is ever pending: fmi2DoStep returns when done"); });
}

/// Layout: time, started, inputs, temperatures as 64-bit words.
std::size_t bytes_of(const FmuState& state) {
  return sizeof(double) * (2 + state.inputs.size() + static_cast<std::size_t>(state.temperatures_K.size()));
}

}  // namespace

const char* fmi2GetTypesPlatform() { return "default"; }

const char* fmi2GetVersion() { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean, std::size_t, const fmi2String[]) {
  return guarded(component, [](Slave&) {});  // only errors are logged, and those always
}

// NOLINTNEXTLINE(readability-function-size): the standard's own
fmi2Component fmi2Instantiate(fmi2String instance_name, fmi2Type type, fmi2String guid, fmi2String resource_location,
                              const fmi2CallbackFunctions* callbacks, fmi2Boolean, fmi2Boolean) {
  if (callbacks == nullptr) return nullptr;
  const char* name = instance_name != nullptr ? instance_name : "";
  try {
    if (*name == '\0') refuse("instance name", "must not be empty");
    if (type != fmi2CoSimulation) refuse("type", "this FMU is for co-simulation");
    if (guid == nullptr || resource_location == nullptr) refuse("guid, resource location", "both are needed");
    return new Slave{name, *callbacks, FmuInstance(guid, resource_location)};
  } catch (const std::exception& error) {
    say(*callbacks, name, error.what());
  } catch (...) {
    say(*callbacks, name, "unknown error");
  }
  return nullptr;
}

void fmi2FreeInstance(fmi2Component component) { delete static_cast<Slave*>(component); }

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean, fmi2Real, fmi2Real start_time, fmi2Boolean,
                               fmi2Real) {
  return guarded(component, [&](Slave& slave) { slave.instance.set_start_time(start_time); });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
  return guarded(component, [](Slave&) {});
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
  return guarded(component, [](Slave& slave) { slave.instance.start(); });
}

fmi2Status fmi2Terminate(fmi2Component component) {
  return guarded(component, [](Slave&) {});
}

fmi2Status fmi2Reset(fmi2Component component) {
  return guarded(component, [](Slave& slave) { slave.instance.reset(); });
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], std::size_t count,
                       fmi2Real values[]) {
  return guarded(component, [&](Slave& slave) {
    for (std::size_t i = 0; i < count; ++i) values[i] = slave.instance.get(references[i]);
  });
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], std::size_t count,
                       const fmi2Real values[]) {
  return guarded(component, [&](Slave& slave) {
    for (std::size_t i = 0; i < count; ++i) slave.instance.set(references[i], values[i]);
  });
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference[], std::size_t count, fmi2Integer[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference[], std::size_t count, fmi2Boolean[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference[], std::size_t count, fmi2String[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference[], std::size_t count, const fmi2Integer[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference[], std::size_t count, const fmi2Boolean[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference[], std::size_t count, const fmi2String[]) {
  return none_of_this_type(component, count);
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return guarded(component, [&](Slave& slave) {
    if (*state == nullptr) {
      *state = new FmuState(slave.instance.state());
    } else {
      *static_cast<FmuState*>(*state) = slave.instance.state();
    }
  });
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
  return guarded(component, [&](Slave& slave) {
    if (state == nullptr) refuse("FMU state", "is null");
    slave.instance.set_state(*static_cast<const FmuState*>(state));
  });
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate* state) {
  return guarded(component, [&](Slave&) {
    if (state == nullptr) return;
    delete static_cast<FmuState*>(*state);
    *state = nullptr;
  });
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, std::size_t* bytes) {
  return guarded(component, [&](Slave&) { *bytes = bytes_of(*static_cast<const FmuState*>(state)); });
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], std::size_t size) {
  return guarded(component, [&](Slave&) {
    const FmuState& from = *static_cast<const FmuState*>(state);
    if (size < bytes_of(from)) refuse("serialised FMU state", "the room given is too small");
    const auto put = [&](const double* numbers, std::size_t count) {
      std::memcpy(bytes, numbers, count * sizeof(double));
      bytes += count * sizeof(double);
    };
    const double started = from.started ? 1.0 : 0.0;
    put(&from.time_s, 1);
    put(&started, 1);
    put(from.inputs.data(), from.inputs.size());
    put(from.temperatures_K.data(), static_cast<std::size_t>(from.temperatures_K.size()));
  });
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], std::size_t size,
                                   fmi2FMUstate* state) {
  return guarded(component, [&](Slave& slave) {
    FmuState to = slave.instance.make_state();
    if (size != bytes_of(to)) refuse("serialised FMU state", "has not the length of this network's states");
    const auto take = [&](double* numbers, std::size_t count) {
      std::memcpy(numbers, bytes, count * sizeof(double));
      bytes += count * sizeof(double);
    };
    double started = 0.0;
    take(&to.time_s, 1);
    take(&started, 1);
    take(to.inputs.data(), to.inputs.size());
    take(to.temperatures_K.data(), static_cast<std::size_t>(to.temperatures_K.size()));
    to.started = started != 0.0;
    if (*state == nullptr) *state = new FmuState;
    *static_cast<FmuState*>(*state) = std::move(to);
  });
}

// NOLINTNEXTLINE(readability-function-size): the standard's own
fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference[], std::size_t,
                                        const fmi2ValueReference[], std::size_t, const fmi2Real[], fmi2Real[]) {
  return guarded(component, [](Slave&) { refuse("directional derivative", "is not offered by this FMU"); });
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference[], std::size_t,
                                       const fmi2Integer[], const fmi2Real[]) {
  return guarded(component, [](Slave&) { refuse("input derivatives", "inputs are held over a step"); });
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference[], std::size_t,
                                        const fmi2Integer[], fmi2Real[]) {
  return guarded(component, [](Slave&) { refuse("output derivatives", "are not offered by this FMU"); });
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean) {
  return guarded(component, [&](Slave& slave) { slave.instance.step(time, step); });
}

fmi2Status fmi2CancelStep(fmi2Component component) { return no_such_status(component); }

fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind, fmi2Status*) { return no_such_status(component); }

fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real* value) {
  if (kind != fmi2LastSuccessfulTime) return no_such_status(component);
  return guarded(component, [&](Slave& slave) { *value = slave.instance.time_s(); });
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind, fmi2Integer*) {
  return no_such_status(component);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean* value) {
  if (kind != fmi2Terminated) return no_such_status(component);
  return guarded(component, [&](Slave&) { *value = 0; });
}

fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind, fmi2String*) {
  return no_such_status(component);
}
