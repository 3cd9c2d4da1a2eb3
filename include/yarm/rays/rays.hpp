#ifndef YARM_RAYS_RAYS_HPP
#define YARM_RAYS_RAYS_HPP

// Ray casting of a depth camera against primitives, called from Python through a C interface
// (yarm.sim.sensors.rays_native). Optical frame: x right, y down, z forward. Rays have z component 1, so a ray's
// parameter is the depth of its hit. Metres throughout; images are row-major, height x width. Not thread-safe on the
// same image.

#include <cstdint>

extern "C" {

/// A pinhole camera whose axis goes through the middle of its image.
struct YarmCamera {
  std::int32_t width;   ///< pixels
  std::int32_t height;  ///< pixels
  double focal_px;      ///< focal length, pixels
  double near_m;        ///< least depth it measures
  double far_m;         ///< greatest depth it measures
};

/// size: box x, y, z; cylinder (axis z) radius, length; sphere radius.
enum YarmShape : std::int32_t { YARM_BOX = 0, YARM_CYLINDER = 1, YARM_SPHERE = 2 };

/// Fills an image with the bare floor, z = 0 of the world, seen from world_from_optical (4 x 4): as far as the camera
/// measures and 1 m on, for the noise's sake; elsewhere with a depth of 1e30 m, no noise, black.
void yarmRaysFloor(const YarmCamera* camera, const double* world_from_optical, std::uint32_t colour, float* depth,
                   float* noise_sigma, std::uint32_t* rgb);

/// Puts solids in front of what an image shows already. Only pixels that a solid's projected bounds cover are looked
/// at. optical_from_world: 4 x 4; for each of the n solids its shape, 3 sizes, pose world <- centre 4 x 4 and colour
/// 0x00RRGGBB. depth, noise_sigma and rgb change where a solid is nearer than the depth there.
void yarmRaysAdd(const YarmCamera* camera, const double* optical_from_world, std::int32_t n, const std::int32_t* shapes,
                 const double* sizes, const double* world_from_solid, const std::uint32_t* colours, float* depth,
                 float* noise_sigma, std::uint32_t* rgb);

/// Writes an image as organised points of x, y, z (float) and rgb, 16 bytes each; z is NaN, and with it x and y, where
/// the noisy depth is out of the camera's range. normals: one standard normal number a pixel, or null for no noise.
void yarmRaysCloud(const YarmCamera* camera, const float* depth, const float* noise_sigma, const std::uint32_t* rgb,
                   const float* normals, void* points);

/// Standard deviation of the depth of a surface seen at the cosine of incidence (yarm.sim.sensors.noise.axial_sigma).
float yarmRaysSigma(double depth, double incidence_cosine);

}  // extern "C"

#endif  // YARM_RAYS_RAYS_HPP
