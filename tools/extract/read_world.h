// Reads what is wanted off a world, after a step.
#pragma once

#include <scree/scree.h>
#include <tools/extract/signals.h>

#include <array>
#include <cstdint>
#include <vector>

namespace scree::extract {

// Which bodies have rows: those that ever existed among these.
struct Choice {
  bool all = true;
  std::vector<std::uint32_t> indices;  // else: ascending
};

// Samples of a part of a recording. A body's row is its index among the chosen ones, or if all are chosen its
// index among all; a joint's is its index. The number of rows may grow from sample to sample.
struct Samples {
  struct Sample {
    std::uint64_t step = 0;
    double time = 0.0;      // s, since the beginning of the part
    std::size_t rows[2]{};  // of bodies and joints
  };
  std::vector<Sample> samples;
  std::array<Values, kSignalCount> values;
  std::vector<std::uint8_t> seen[2];  // by row of bodies and joints: whether it ever existed
};

// The step that was played.
struct PlayedStep {
  float dt = 0.0f;            // s; 0: none was
  std::vector<Vec3> centers;  // m, of mass as it began, by BodyId::index; for contact_torque
  // s, by BodyId::index: the time step in which a body was awake last, whose impulses its contacts keep while
  // it sleeps; for contact_force and contact_torque.
  std::vector<float> awake_dt;
};

// After each step that was played.
void note_awake(const World& world, PlayedStep& played);

std::vector<Vec3> centers_of_mass(const World& world);

void add_sample(const World& world, const Wanted& wanted, const Choice& choice, std::uint64_t step,
                double time, const PlayedStep& played, Samples& samples);

void add_events(const World& world, const Choice& choice, std::uint64_t step, double time,
                std::vector<EventRow>& events);

}  // namespace scree::extract
