// Vectors with three components.
#pragma once

#include <cmath>

namespace phynness::loop {

struct Vector {
  double x = 0, y = 0, z = 0;
};
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(double s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline bool finite(Vector a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
inline bool equal(Vector a, Vector b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline Vector load(const double* v) { return {v[0], v[1], v[2]}; }
inline void store(Vector a, double* v) {
  v[0] = a.x;
  v[1] = a.y;
  v[2] = a.z;
}
/// a, shortened to `longest`.
inline Vector shortened(Vector a, double longest) {
  const double size = length(a);
  return size > longest ? (longest / size) * a : a;
}

}  // namespace phynness::loop
