// What can be extracted from a recording, and the arrays that it becomes.
#pragma once

#include <scree/ids.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scree::extract {

// Whose quantity it is: there is a row for each of these.
enum class Owner : std::uint8_t { body, joint, world };

enum class Signal : std::uint8_t {
  position,
  rotation,
  linear_velocity,
  angular_velocity,
  awake,
  kinetic_energy,
  potential_energy,
  contact_force,
  contact_torque,
  joint_force,
  joint_torque,
  total_kinetic_energy,
  total_potential_energy,
  contacts,
  awake_bodies,
  residual,
  penetration,
};
inline constexpr int kSignalCount = 17;

struct SignalInfo {
  const char* name;
  const char* unit;
  Owner owner;
  int width;      // numbers a row
  bool is_wide;   // double precision
  bool of_steps;  // it is of a step: there is none where no step has been played
};

const SignalInfo& info_of(Signal signal);

// Names of the numbers of a row: "" alone, or "_x", "_y", "_z", "_w".
std::span<const char* const> components_of(const SignalInfo& info);

// What is asked for by name: signals in the order of the names, each once, and whether events are, too.
// `pose` stands for position and rotation, `velocity` for both velocities, `energy` for all energies of
// bodies and the sums of them. Throws Error for an unknown name.
struct Wanted {
  std::vector<Signal> signals;
  bool events = false;

  bool has(Signal signal) const;
  bool has(Owner owner) const;
};
Wanted read_signals(std::span<const std::string> names);

// For messages: all names that read_signals knows.
std::string signal_names();

// The values of a signal, in single or double precision: steps one behind the other, in each a row for each
// owner. Not a number: the owner did not exist, or no step had been played.
struct Values {
  bool is_wide = false;
  std::vector<float> single;
  std::vector<double> wide;

  std::size_t size() const { return is_wide ? wide.size() : single.size(); }
  double operator[](std::size_t i) const { return is_wide ? wide[i] : double{single[i]}; }
  void add(double value) {
    if (is_wide) {
      wide.push_back(value);
    } else {
      single.push_back(static_cast<float>(value));
    }
  }
};

enum class EventKind : std::uint8_t {
  contact_begin,
  contact_end,
  contact_hit,
  sensor_begin,
  sensor_end,
  sleep_begin,
  sleep_end,
  joint_over,  // a joint bore more than its thresholds for events
  joint_broken,
  restored,  // a body's state became non-finite, and the body was put back
};
const char* name_of(EventKind kind);

struct EventRow {
  static constexpr std::int64_t kNone = -1;

  std::uint64_t step = 0;
  double time = 0.0;  // s, since the first sample
  EventKind kind = EventKind::contact_begin;
  std::int64_t body_a = kNone, body_b = kNone;  // indices; of a sensor's events the sensor's comes first
  std::int64_t shape_a = kNone, shape_b = kNone;
  std::int64_t joint = kNone;
  double value = 0.0;  // m/s of approach of begins and hits; N of joints; else 0
};

// All that was extracted.
struct Extract {
  std::vector<std::uint64_t> steps;           // step counters of the samples
  std::vector<double> times;                  // s, since the first sample
  std::vector<std::uint32_t> bodies, joints;  // indices of the rows
  Wanted wanted;
  std::array<Values, kSignalCount> values;  // of those that are wanted
  std::vector<EventRow> events;

  std::size_t rows_of(Owner owner) const {
    return owner == Owner::body ? bodies.size() : owner == Owner::joint ? joints.size() : 1;
  }
};

}  // namespace scree::extract
