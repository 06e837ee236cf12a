// sphere, shell, torus: a smooth step of a signed distance.
#include <cmath>

#include "volume/analytic_form.h"

namespace vol::volume {
namespace {

/// Signed distance to a surface, negative inside, and its gradient (a unit vector, 0 where it is undefined).
struct Distance {
  double d;
  Vec3 normal;
};

/// f = S(1/2 - d / w), S(t) = t^3 (10 - 15 t + 6 t^2) between t = 0 and 1: twice continuously differentiable,
/// 1 inside, 0 outside, 1/2 exactly on the surface, the edge w wide. S'(t) = 30 t^2 (1 - t)^2.
class Edge : public AnalyticForm {
 public:
  explicit Edge(double width) : width_(width) {}
  double value(const Vec3& p) const override {
    const double t = parameter(distance(p).d);
    return t * t * t * (10 + t * (6 * t - 15));
  }
  Vec3 gradient(const Vec3& p) const override {
    const Distance at = distance(p);
    const double t = parameter(at.d);
    return -30 * t * t * (1 - t) * (1 - t) / width_ * at.normal;
  }

 protected:
  [[nodiscard]] virtual Distance distance(const Vec3& p) const = 0;

 private:
  [[nodiscard]] double parameter(double d) const { return std::fmin(std::fmax(0.5 - d / width_, 0), 1); }
  double width_;
};

Vec3 unit(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : Vec3(Vec3::Zero());
}

class Sphere : public Edge {
 public:
  Sphere() : Edge(0.2) {}

 private:
  Distance distance(const Vec3& p) const override { return {p.norm() - 0.6, unit(p)}; }
};

class Shell : public Edge {
 public:
  Shell() : Edge(0.1) {}

 private:
  Distance distance(const Vec3& p) const override {
    const double off = p.norm() - 0.6;  // from the middle of the wall, which is 0.2 thick
    return {std::abs(off) - 0.1, std::copysign(1.0, off) * unit(p)};
  }
};

class Torus : public Edge {
 public:
  Torus() : Edge(0.16) {}

 private:
  Distance distance(const Vec3& p) const override {
    const double r = std::hypot(p.x(), p.y());
    const Vec3 to_axis = r > 0 ? Vec3(p.x() / r, p.y() / r, 0) : Vec3(Vec3::Zero());
    const Vec3 off = (r - 0.55) * to_axis + Vec3(0, 0, p.z());  // from the ring
    return {off.norm() - 0.22, unit(off)};
  }
};

}  // namespace

FormPointer make_shape_form(std::string_view name, const AnalyticOptions&) {
  if (name == "sphere") return std::make_shared<Sphere>();
  if (name == "shell") return std::make_shared<Shell>();
  if (name == "torus") return std::make_shared<Torus>();
  return nullptr;
}

}  // namespace vol::volume
