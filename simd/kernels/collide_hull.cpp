// Hull against hull and box against hull.
#include <simd/kernels/collide_contact.h>

namespace scree::simd::SCREE_SIMD_NAMESPACE {

void collide_box_hull(const CollideColumns& columns, const CollideItem* items, int count);
void collide_hull_hull(const CollideColumns& columns, const CollideItem* items, int count);

namespace {

void report_no_contact(const CollideColumns& columns, const CollideItem* items, int count) {
  for (int i = 0; i < count; ++i) {
    columns.points[items[i].row] = 0;
    columns.manifold[items[i].row].info = 0;
  }
}

}  // namespace

void collide_box_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  report_no_contact(columns, items, count);
}
void collide_hull_hull(const CollideColumns& columns, const CollideItem* items, int count) {
  report_no_contact(columns, items, count);
}

}  // namespace scree::simd::SCREE_SIMD_NAMESPACE
