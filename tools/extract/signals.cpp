// See signals.h.
#include <scree/error.h>
#include <tools/extract/signals.h>

#include <algorithm>
#include <iterator>

namespace scree::extract {
namespace {

constexpr SignalInfo kInfos[kSignalCount] = {
    {"position", "m", Owner::body, 3, false, false},
    {"rotation", "", Owner::body, 4, false, false},
    {"linear_velocity", "m/s", Owner::body, 3, false, false},
    {"angular_velocity", "rad/s", Owner::body, 3, false, false},
    {"awake", "", Owner::body, 1, false, false},
    {"kinetic_energy", "J", Owner::body, 1, true, false},
    {"potential_energy", "J", Owner::body, 1, true, false},
    {"contact_force", "N", Owner::body, 3, false, true},
    {"contact_torque", "N m", Owner::body, 3, false, true},
    {"joint_force", "N", Owner::joint, 3, false, true},
    {"joint_torque", "N m", Owner::joint, 3, false, true},
    {"total_kinetic_energy", "J", Owner::world, 1, true, false},
    {"total_potential_energy", "J", Owner::world, 1, true, false},
    {"contacts", "", Owner::world, 1, true, true},
    {"awake_bodies", "", Owner::world, 1, true, true},
    {"residual", "m/s", Owner::world, 1, true, true},
    {"penetration", "m", Owner::world, 1, true, true},
};

struct Group {
  const char* name;
  std::vector<Signal> signals;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> all = {{"pose", {Signal::position, Signal::rotation}},
                                         {"velocity", {Signal::linear_velocity, Signal::angular_velocity}},
                                         {"energy",
                                          {Signal::kinetic_energy, Signal::potential_energy,
                                           Signal::total_kinetic_energy, Signal::total_potential_energy}}};
  return all;
}

void add(Signal signal, std::vector<Signal>& signals) {
  if (std::find(signals.begin(), signals.end(), signal) == signals.end()) signals.push_back(signal);
}

bool add_signals(const std::string& name, std::vector<Signal>& signals) {
  for (int i = 0; i < kSignalCount; ++i) {
    if (name != kInfos[i].name) continue;
    add(static_cast<Signal>(i), signals);
    return true;
  }
  for (const Group& group : groups()) {
    if (name != group.name) continue;
    for (const Signal signal : group.signals) add(signal, signals);
    return true;
  }
  return false;
}

}  // namespace

const SignalInfo& info_of(Signal signal) { return kInfos[static_cast<int>(signal)]; }

std::span<const char* const> components_of(const SignalInfo& info) {
  static constexpr const char* kAlone[] = {""};
  static constexpr const char* kAxes[] = {"_x", "_y", "_z", "_w"};
  if (info.width == 1) return kAlone;
  return std::span(kAxes).first(static_cast<std::size_t>(info.width));
}

bool Wanted::has(Signal signal) const {
  return std::find(signals.begin(), signals.end(), signal) != signals.end();
}

bool Wanted::has(Owner owner) const {
  return std::any_of(signals.begin(), signals.end(),
                     [owner](Signal signal) { return info_of(signal).owner == owner; });
}

Wanted read_signals(std::span<const std::string> names) {
  Wanted wanted;
  for (const std::string& name : names) {
    if (name == "events") {
      wanted.events = true;
    } else if (!add_signals(name, wanted.signals)) {
      throw Error("--signal " + name + ": unknown signal; there are: " + signal_names());
    }
  }
  return wanted;
}

std::string signal_names() {
  std::string names;
  for (const SignalInfo& info : kInfos) names += std::string(info.name) + ", ";
  for (const Group& group : groups()) names += std::string(group.name) + ", ";
  return names + "events";
}

const char* name_of(EventKind kind) {
  constexpr const char* kNames[] = {"contact_begin", "contact_end", "contact_hit", "sensor_begin",
                                    "sensor_end",    "sleep_begin", "sleep_end",   "joint_over",
                                    "joint_broken",  "restored"};
  return kNames[static_cast<int>(kind)];
}

}  // namespace scree::extract
