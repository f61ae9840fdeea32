// A show as the bytes that a page plays: small, and quick to read in a browser.
//
//   u32    length of the head
//   ...    the head, JSON: title, up, size, times, steps, stats, meshes, bodies
//   ...    numbers, to whose bytes the head's offsets point: positions, normals and indices of meshes as
//   float and
//          u32, then tracks
//
// A track has the poses of a body that moves. Positions are in equal parts of the box that the body's origin
// stays in: 2^16 - 1 of them, or where these would be larger than 1/500 of the body's size, 2^24 - 1 or
// 2^32 - 1. Rotations are in parts of 1/32,767. For each of the seven components come the differences from
// sample to sample, modulo a power of 256, all their lowest bytes first. All of it is packed by gzip, which
// makes little of what rests or moves evenly.
#pragma once

#include <tools/export/show.h>

#include <string>

namespace scree::view {

std::string make_clip(const exports::Show& show, const std::string& title);

}  // namespace scree::view
