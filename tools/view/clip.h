// A show as the bytes that a page plays: small, and quick to read in a browser.
//
//   u32    length of the head
//   ...    the head, JSON: title, up, size, times, steps, stats, meshes, bodies
//   ...    numbers, to whose bytes the head's offsets point: positions, normals and indices of meshes as
//   float and
//          u32, then tracks
//
// A track has the poses of a body that moves, in 14 bytes each: the position in 65,535 parts of the box that
// the body's origin stays in, and the rotation in parts of 1/32,767. For each of the seven components come
// the differences from sample to sample, modulo 2^16, their low bytes and then their high bytes. All of it is
// packed by gzip, which makes little of what rests or moves evenly.
#pragma once

#include <tools/export/show.h>

#include <string>

namespace scree::view {

std::string make_clip(const exports::Show& show, const std::string& title);

}  // namespace scree::view
