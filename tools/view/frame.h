// A world at a step as the bytes that `scree view` sends to pages, and who is in it.
//
// Pages learn of bodies and meshes once, by news, and know them by number from then on. All tracks of a
// server share the numbers: a body that is the same in two of them has the same one, which is how branches
// and recordings are compared. Three kinds of binary messages, of little-endian numbers; each begins with its
// kind:
//
//   1 news     u32 kind, u32 length of the head, the head in JSON (meshes, see pieces.h; how many bodies n
//              and pieces m there are, and where their columns begin in the numbers), then the numbers of
//              the meshes and the columns: n u32 bodies by index, n u32 how many shapes, n u32 how many
//              pieces, n float masses, kg, 7n float poses, 3n float centers of mass in the body's frame, m;
//              of all pieces, one body's behind the other's, m u32 meshes, 7m float poses in the body's
//              frame, 3m float scales; n u8 types (0 fixed, 1 kinematic, 2 dynamic)
//   2 roster   u32 kind, u32 roster, u32 count, then as many u32: bodies that stand still, by number
//   3 frame    u32 kind, u32 track, f64 step,
//              u32 roster, u32 n, u32 contacts, u32 joints, u32 shade, u32 has-details,
//              n u32 numbers of bodies that move, 3n float positions, m, n float speeds, m/s, n float values,
//              4n i16 rotations in parts of 1/32,767, n u8 awake, filled up to a multiple of four bytes;
//              then the contacts, the joints, and where there are details n float energies of the bodies, J,
//              kinetic and potential
//
// A contact is 12 words: 2 u32 bodies by index, 3 float place, 3 float normal, float force in N, float color,
// float separation in m, u32 0. A joint is 12 words: its two anchors in m, the force in N
// and the torque in N m that it bears (8 floats), 2 u32 bodies by index (2^32 - 1: the world), u32 index, u32
// kind.
#pragma once

#include <scree/scree.h>
#include <tools/view/pieces.h>

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

namespace scree::view {

using Bytes = std::shared_ptr<const std::string>;

// A number of each body besides its pose, to color it by.
enum class Shade : std::uint8_t {
  none,
  island,    // the lowest number of a body that contacts and joints connect it with
  color,     // the highest color of its contacts; -1: none
  residual,  // m/s: the fastest approach that is left at one of its contacts that press
  force,     // N: of all its contacts along their normals
};

struct FrameOptions {
  Shade shade = Shade::none;
  bool details = false;  // contacts and joints

  friend auto operator<=>(const FrameOptions&, const FrameOptions&) = default;
};

// What pages know of bodies.
class Cast {
 public:
  // What a track remembers from frame to frame, to find numbers quickly.
  class Memory {
    friend class Cast;
    struct Known {
      std::uint32_t generation = 0, number = 0;
      BodyType type = BodyType::dynamic;
      std::size_t shapes = 0;
      Pose pose;               // of fixed bodies, as pages know it
      bool has_moved = false;  // a fixed body that was put elsewhere comes with those that move
    };
    std::vector<Known> known;  // by BodyId::index
    std::vector<std::uint32_t> standing;
    std::uint32_t roster = 0;
  };

  // Who is there: bodies that may move, and the number of the roster of those that stand still.
  struct Present {
    std::vector<BodyId> moving;
    std::vector<std::uint32_t> numbers;
    std::uint32_t roster = 0;
  };

  Cast() : meshes_(numbers_) {}
  Cast(const Cast&) = delete;
  Cast& operator=(const Cast&) = delete;

  Present find(const World& world, Memory& memory);
  // Messages since the last call; in order, and to be sent before the frame that they came with.
  std::vector<Bytes> take_news();
  // All messages so far, for a page that is new.
  const std::vector<Bytes>& all_news() const { return all_news_; }
  // m, of the largest dynamic body, or where none has been seen, of the largest one; 0: no shapes.
  float size() const { return size_ > 0.0f ? size_ : other_size_; }

 private:
  // Bodies that no message has had yet, in the columns of a message.
  struct Columns {
    std::vector<std::uint32_t> indices, shape_counts, piece_counts, meshes;
    std::vector<float> masses, poses, centers, piece_poses, scales;
    std::vector<std::uint8_t> types;
  };
  // A hash of what tells a body from all others, of 128 bits: it takes a tenth of the memory.
  using Content = std::array<std::uint64_t, 2>;
  struct Low {
    std::size_t operator()(const Content& content) const { return static_cast<std::size_t>(content[0]); }
  };

  std::uint32_t number_of(const World& world, BodyId body);
  void add(const World& world, BodyId body, const std::vector<exports::ActorShape>& shapes);
  std::string take_new_bodies();
  std::uint32_t roster_of(std::vector<std::uint32_t> standing);
  void say(std::string message);

  std::string numbers_;
  Meshes meshes_;
  Columns new_bodies_;
  std::unordered_map<Content, std::uint32_t, Low> by_content_;
  std::map<std::vector<std::uint32_t>, std::uint32_t> rosters_;
  std::vector<Bytes> news_, all_news_;
  float size_ = 0.0f, other_size_ = 0.0f;
};

// `dt`: s, of the step that has brought the world, or 0.
std::string make_frame(const World& world, std::uint32_t track, std::uint64_t step, float dt,
                       const FrameOptions& options, Cast& cast, Cast::Memory& memory);

}  // namespace scree::view
