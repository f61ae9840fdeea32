// An extract as the bytes of a file.
#pragma once

#include <tools/extract/signals.h>

#include <string>

namespace scree::extract {

// An archive of arrays as NumPy's `load` reads it. Throws std::runtime_error with libarchive's reason.
std::string to_npz(const Extract& extract);

// A table with a line for each sample and each body or joint. Throws Error where the signals do not fit into
// one table: those of bodies, of joints, of the world, and events.
std::string to_csv(const Extract& extract);
void check_fits_csv(const Wanted& wanted);

}  // namespace scree::extract
