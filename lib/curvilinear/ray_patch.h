#pragma once
#include <vector>

#include "camera/camera.h"
#include "curvilinear/face.h"

namespace vol::curvilinear {

/// The world as a ray sees it: x and y across, z along it, a right-handed orthonormal frame.
struct RayFrame {
  Vec3 origin, across_x, across_y, along;
  double t_origin = 0;  ///< the ray's t at z = 0

  /// \param near  the frame's origin is the point of the ray closest to it: so z keeps its digits where the
  ///              ray starts far away
  RayFrame(const camera::Ray& ray, const Vec3& near);
};

/// A bicubic Bezier face in the frame of a ray: [r + 4 s], r along the face's first parameter u, s along v.
/// The ray is x = y = 0.
struct RayPatch {
  double x[16], y[16], z[16];
  RayPatch() = default;
  RayPatch(const FacePatch& face, const RayFrame& frame);
};

/// Where the ray passes the face.
struct PatchHit {
  double u, v, z;
  int sign;  ///< of z' (du x dv): +1 where the face's normal points along the ray; +-2, ... where rounding
             ///< parts no more
};

/// How often the border of the face winds around the ray, counter-clockwise positive. It is the sum of what
/// its four border curves contribute, each of which depends on the bits of its own control points alone: on
/// the signed crossings of the half line y = 0, x > 0, found by halving the curve, a point on the line
/// counting as above it. So over the faces of a closed cell the windings sum to 0 exactly, wherever the ray
/// passes, edges and corners included: an edge contributes to its two faces with opposite signs.
[[nodiscard]] int winding(const RayPatch& patch);

/// Appends where the ray passes the face; the signs sum to winding(patch), always.
///
/// The face is halved until a part's control points are all on one side of the ray in x or in y, or until its
/// tangents along u and along v lie in cones that part: then it is one to one, and its own winding number
/// (the same sum, over its own borders) says whether the ray meets it; Newton finds where, and where it does
/// not converge inside, halving does, by the winding number. Windings add up exactly when a part is halved,
/// since both parts share the new border to the bit. A part that is a straight line but for the rounding of
/// its control points (the face seen edge-on, or what is left around a fold) has no crossings but those that
/// its winding number asks for: a pair nearer than that is left out together.
void append_hits(const RayPatch& patch, std::vector<PatchHit>& hits);

}  // namespace vol::curvilinear
