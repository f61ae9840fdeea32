// See parts.h. The choice of the plane weighs as Mamou and Ghorbel (2009) do: what is left of concavity, here
// the volume of the two hulls, and a little for halves of the same size.
#include <core/geometry/decompose/parts.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::decomposition {

namespace {

constexpr double kProxyCells = 20.0;      // surfaces are this coarse while planes are tried out
constexpr int kProxyCorners = 40;         // of a hull then
constexpr double kProxyTolerance = 2e-3;  // of the extent of a part
constexpr double kImbalanceWeight = 0.02;
constexpr double kSlicingWeight = 0.03;
constexpr double kLeastShare = 1e-4;  // of the volume of a part, for either side of a cut
constexpr int kRefinements = 2;
constexpr double kLeastGain = 0.05;  // share of the volume of a hull; below it the next cuts are tried, too

// Among planes that are as good, those along faces win: they make parts that people would have made.
double penalty(const CutPlane& cut_plane) {
  // Slices of slices would never end.
  const double slicing = kSlicingWeight * cut_plane.thinness;
  switch (cut_plane.kind) {
    case PlaneKind::face:
    case PlaneKind::gap:
      return 0.0;
    case PlaneKind::axis:
      return 0.01 + slicing;
    case PlaneKind::half:
    case PlaneKind::diagonal:
      return 0.025 + slicing;
  }
  return 0.0;
}

std::vector<Vector> points_of(const Fragments& fragments, const Cell& cell) {
  std::vector<Vector> points = fragments.points;
  for (const CellCorner& corner : cell.corners) {
    if (corner.in_solid) points.push_back(corner.point);
  }
  return points;
}

// What is left of a part, coarsely, while planes are tried out.
struct Region {
  Cell cell;
  Fragments fragments;
  double volume = 0.0;  // m^3, of its hull
};

class Trial {
 public:
  Trial(const CellPart& part, const Workshop& workshop) : solid_(*part.solid), workshop_(workshop) {
    tolerance_ = kProxyTolerance * part.shell.bounds.extent();
    whole_ = {part.cell, simplify(part.fragments, kProxyCells), 0.0};
    whole_.volume = volume_of(whole_);
  }

  const Region& whole() const { return whole_; }

  // Both sides of a plane; false where one has next to nothing.
  bool divide(const Region& region, const Plane& plane, std::array<Region, 2>& sides) const {
    std::array<Fragments, 2> fragments =
        decomposition::divide(region.fragments, plane, solid_.piece.inside_out, workshop_.tolerance);
    std::array<Cell, 2> cells = cut(region.cell, plane, solid_.winding, workshop_.tolerance);
    for (std::size_t i = 0; i < 2; ++i) {
      sides[i] = {std::move(cells[i]), std::move(fragments[i]), 0.0};
      sides[i].volume = volume_of(sides[i]);
      if (!(sides[i].volume > kLeastShare * region.volume)) return false;
    }
    return true;
  }

  // Lower is better; 1 and more: the hulls of the sides have the volume of that of the whole.
  double score(const std::array<Region, 2>& sides, const CutPlane& cut_plane, double volume) const {
    const double sum = sides[0].volume + sides[1].volume;
    const double imbalance = std::abs(sides[0].volume - sides[1].volume) / sum;
    return volume / whole_.volume + kImbalanceWeight * imbalance + penalty(cut_plane);
  }

 private:
  double volume_of(const Region& region) const {
    return make_shell(workshop_.grid, points_of(region.fragments, region.cell), kProxyCorners, tolerance_)
        .volume;
  }

  const Solid& solid_;
  const Workshop& workshop_;
  double tolerance_ = 0.0;
  Region whole_;
};

struct Choice {
  CutPlane cut_plane;
  double score = std::numeric_limits<double>::infinity();

  bool is_cut() const { return std::isfinite(score); }
};

Choice try_plane(const Trial& trial, const CutPlane& cut_plane) {
  std::array<Region, 2> sides;
  if (!trial.divide(trial.whole(), cut_plane.plane, sides)) return {};
  return {cut_plane, trial.score(sides, cut_plane, sides[0].volume + sides[1].volume)};
}

// m^3: the least volume that one more cut, through the middle, leaves of a region.
double volume_after_cut(const Trial& trial, const Region& region) {
  double least = region.volume;
  std::array<Region, 2> sides;
  for (const CutPlane& cut_plane : find_middle_planes(region.fragments)) {
    if (trial.divide(region, cut_plane.plane, sides))
      least = std::min(least, sides[0].volume + sides[1].volume);
  }
  return least;
}

// Around a hollow one cut alone gains nothing, whichever it is. Then that one is best after which the next
// ones gain most: a search of depth two, of the kind that Wei et al. (2022) do.
Choice look_ahead(const Trial& trial, const std::vector<Choice>& choices) {
  Choice best;
  std::array<Region, 2> sides;
  for (const Choice& choice : choices) {
    if (!trial.divide(trial.whole(), choice.cut_plane.plane, sides)) continue;
    const double volume = volume_after_cut(trial, sides[0]) + volume_after_cut(trial, sides[1]);
    const double score = trial.score(sides, choice.cut_plane, volume);
    if (score < best.score) best = {choice.cut_plane, score};
  }
  return best;
}

// The best choice of each direction, and of all that have none.
std::vector<Choice> shortlist(const std::vector<Choice>& choices) {
  constexpr std::size_t kMostOthers = 5;
  std::vector<Choice> chosen, others;
  for (const Choice& choice : choices) {
    if (!choice.is_cut()) continue;
    if (choice.cut_plane.spacing == 0.0) {
      others.push_back(choice);
    } else if (chosen.empty() || chosen.back().cut_plane.plane.normal != choice.cut_plane.plane.normal) {
      chosen.push_back(choice);
    } else if (choice.score < chosen.back().score) {
      chosen.back() = choice;
    }
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const Choice& a, const Choice& b) { return a.score < b.score; });
  others.resize(std::min(others.size(), kMostOthers));
  chosen.insert(chosen.end(), others.begin(), others.end());
  return chosen;
}

Choice refine(const Trial& trial, Choice best) {
  for (int i = 0; i < kRefinements && best.cut_plane.spacing > 0.0; ++i) {
    best.cut_plane.spacing *= 0.5;
    const CutPlane middle = best.cut_plane;
    for (const double step : {-middle.spacing, middle.spacing}) {
      CutPlane moved = middle;
      moved.plane.offset += step;
      const Choice other = try_plane(trial, moved);
      if (other.score < best.score) best = other;
    }
  }
  return best;
}

Choice choose(const CellPart& part, const Workshop& workshop) {
  const Trial trial(part, workshop);
  std::vector<Choice> choices;
  Choice best;
  for (const CutPlane& cut_plane : find_planes(part.cell, part.solid->edges, trial.whole().fragments,
                                               workshop.concavity, workshop.tolerance)) {
    choices.push_back(try_plane(trial, cut_plane));
    if (choices.back().score < best.score) best = choices.back();
  }
  if (best.is_cut() && best.score > 1.0 - kLeastGain) return look_ahead(trial, shortlist(choices));
  return refine(trial, best);
}

void complete(CellPart& part, Workshop& workshop) {
  part.points = points_of(part.fragments, part.cell);
  part.shell = workshop.shell_of(part.points);
  part.own_volume = part.shell.volume;
  part.concavity = workshop.lattice.concavity(part.shell, std::numeric_limits<double>::infinity());
}

}  // namespace

Workshop::Workshop(const Surface& surface, const DecomposeOptions& options)
    : lattice(surface, options.resolution), grid(surface.bounds()) {
  const double extent = surface.bounds().extent();
  tolerance = 0x1p-20 * extent;
  concavity = options.concavity > 0.0f ? static_cast<double>(options.concavity)
                                       : static_cast<double>(options.concavity_share) * extent;
}

Shell Workshop::shell_of(std::span<const Vector> points) const {
  constexpr int kCorners = 128;
  return make_shell(grid, points, kCorners, tolerance);
}

CellPart whole_part(const Solid& solid, Workshop& workshop) {
  CellPart part;
  part.solid = &solid;
  Bounds bounds = solid.piece.surface.bounds();
  const double margin = 0.01 * bounds.extent();
  for (std::size_t k = 0; k < 3; ++k) {
    bounds.lower[k] -= margin;
    bounds.upper[k] += margin;
  }
  part.cell = make_cell(bounds);
  part.fragments = make_fragments(solid.piece.surface);
  complete(part, workshop);
  return part;
}

std::optional<std::array<CellPart, 2>> cut_part(const CellPart& part, Workshop& workshop) {
  if (!part.shell.is_solid()) return std::nullopt;
  const Choice choice = choose(part, workshop);
  if (!choice.is_cut()) return std::nullopt;
  const Plane& plane = choice.cut_plane.plane;
  std::array<Cell, 2> cells = cut(part.cell, plane, part.solid->winding, workshop.tolerance);
  std::array<Fragments, 2> sides =
      divide(part.fragments, plane, part.solid->piece.inside_out, workshop.tolerance);
  std::array<CellPart, 2> halves;
  for (std::size_t i = 0; i < 2; ++i) {
    halves[i].solid = part.solid;
    halves[i].cell = std::move(cells[i]);
    halves[i].fragments = std::move(sides[i]);
    complete(halves[i], workshop);
    if (!halves[i].shell.is_solid()) return std::nullopt;
  }
  return halves;
}

}  // namespace scree::decomposition
