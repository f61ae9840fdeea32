// Materials as kernels read them.
#pragma once

#include <core/plain/rows.h>
#include <scree/shapes.h>

namespace scree {

// Of a material that has been checked. Density has no part in it.
MaterialRow material_row(const Material& material);

}  // namespace scree
