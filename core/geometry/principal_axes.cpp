// Principal axes by Jacobi's method: turns about one pair of axes after the other until the matrix is
// diagonal. See scree/mesh.h. Plain double arithmetic of a fixed order, for the same bits everywhere.
#include <core/world/number_text.h>
#include <scree/error.h>
#include <scree/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace scree {

namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// Each sweep squares what is left beside the diagonal, so that six are usual.
constexpr int kMostSweeps = 30;

// Turns the matrix so that entry (p, q) vanishes; the columns of `axes` turn along. (Golub, Van Loan, Matrix
// Computations, section 8.5: the smaller of the two angles.)
void turn(Matrix& matrix, Matrix& axes, std::size_t p, std::size_t q) {
  if (matrix[p][q] == 0.0) return;
  const double ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
  const double tangent = ratio >= 0.0 ? 1.0 / (ratio + std::sqrt(1.0 + ratio * ratio))
                                      : -1.0 / (-ratio + std::sqrt(1.0 + ratio * ratio));
  const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = tangent * cosine;
  const auto mix = [&](double& first, double& second) {
    const double old_first = first;
    first = cosine * old_first - sine * second;
    second = sine * old_first + cosine * second;
  };
  for (std::size_t i = 0; i < 3; ++i) mix(matrix[i][p], matrix[i][q]);
  for (std::size_t i = 0; i < 3; ++i) mix(matrix[p][i], matrix[q][i]);
  for (std::size_t i = 0; i < 3; ++i) mix(axes[i][p], axes[i][q]);
  matrix[p][q] = matrix[q][p] = 0.0;
}

void diagonalize(Matrix& matrix, Matrix& axes) {
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    if (matrix[0][1] == 0.0 && matrix[0][2] == 0.0 && matrix[1][2] == 0.0) return;
    turn(matrix, axes, 0, 1);
    turn(matrix, axes, 0, 2);
    turn(matrix, axes, 1, 2);
  }
}

using Axis = std::array<double, 3>;

// To the side where the largest component is positive; of equal ones the first.
Axis pointed(Axis axis) {
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(axis[i]) > std::abs(axis[largest])) largest = i;
  }
  if (axis[largest] < 0.0) {
    for (double& component : axis) component = -component;
  }
  return axis;
}

Axis cross(const Axis& a, const Axis& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The rotation whose matrix has these columns, with w >= 0. Divides by the largest component. (Shepperd,
// Quaternion from rotation matrix, 1978.)
Quat rotation_of(const Axis& x, const Axis& y, const Axis& z) {
  const double squares[4] = {1.0 + x[0] - y[1] - z[2], 1.0 - x[0] + y[1] - z[2], 1.0 - x[0] - y[1] + z[2],
                             1.0 + x[0] + y[1] + z[2]};  // four times those of x, y, z, w
  const int largest = static_cast<int>(std::max_element(squares, squares + 4) - squares);
  const double rows[4][4] = {{squares[0], x[1] + y[0], z[0] + x[2], y[2] - z[1]},
                             {x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]},
                             {z[0] + x[2], y[2] + z[1], squares[2], x[1] - y[0]},
                             {y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]}};
  const double* row = rows[largest];
  double length = 0.0;
  for (int i = 0; i < 4; ++i) length += row[i] * row[i];
  const double scale = (row[3] < 0.0 ? -1.0 : 1.0) / std::sqrt(length);
  const auto component = [&](int i) { return static_cast<float>(row[i] * scale + 0.0); };
  return {component(0), component(1), component(2), component(3)};
}

}  // namespace

PrincipalAxes principal_axes(const MassProperties& properties) {
  const float* inertia = properties.inertia;
  for (int i = 0; i < 6; ++i) {
    if (std::isfinite(inertia[i])) continue;
    throw Error("principal_axes: entry " + std::to_string(i) + " of the inertia is " +
                number_text(inertia[i], 9) + ", must be finite");
  }
  Matrix matrix{{{inertia[0], inertia[3], inertia[4]},
                 {inertia[3], inertia[1], inertia[5]},
                 {inertia[4], inertia[5], inertia[2]}}};
  Matrix axes{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  diagonalize(matrix, axes);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return matrix[a][a] < matrix[b][b]; });
  const auto axis = [&](std::size_t place) {
    const std::size_t column = order[place];
    return pointed({axes[0][column], axes[1][column], axes[2][column]});
  };
  const Axis first = axis(0), second = axis(1);
  const auto moment = [&](std::size_t place) {
    return static_cast<float>(matrix[order[place]][order[place]]);
  };
  return {rotation_of(first, second, cross(first, second)), {moment(0), moment(1), moment(2)}};
}

}  // namespace scree
