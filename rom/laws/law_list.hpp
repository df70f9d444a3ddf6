#pragma once

#include <variant>

#include "rom/laws/air_gap.hpp"
#include "rom/laws/bearing_friction.hpp"
#include "rom/laws/bearing_preload.hpp"
#include "rom/laws/contact_conductance.hpp"
#include "rom/laws/coolant_channel.hpp"
#include "rom/laws/motor_loss.hpp"
#include "rom/laws/rotating_surface.hpp"
#include "rom/laws/windage.hpp"

namespace spindle_twin::rom {

/// All laws there are, and the only list of them; what a law consists of: rom/laws/law.hpp. Messages and tables name
/// them in this order.
using LawParameters =
    std::variant<BearingHeatLaw, WindageLaw, CopperLaw, MotorEfficiencyLaw, IronLaw, ContactLaw, ChannelLaw,
                 CylinderLaw, DiscLaw, StillCylinderLaw, AirGapLaw, EndWindingLaw, BearingPathLaw>;

}  // namespace spindle_twin::rom
