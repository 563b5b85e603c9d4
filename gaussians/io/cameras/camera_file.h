#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"

namespace pliant {

struct CameraFile {
  std::vector<Camera> cameras;
  std::string format;                        ///< for example "COLMAP binary"
  int frames = 0;                            ///< listed in the file
  int photos_found = 0;                      ///< of them on disk
  std::string missing_photo;                 ///< as the first frame names it that has none; empty = none is missing
  std::vector<std::filesystem::path> files;  ///< every camera file that was read
  std::vector<std::string> warnings;
};

/// What reading does where photos are not pictures of a pinhole camera of their own size.
enum class PhotoFit {
  kFirstPhoto,  ///< cameras of one size follow the size of the first photo among them; a lens is warned about
  kEachPhoto,   ///< nothing: the caller fits every camera to its photo and undoes the lens
  kView         ///< as kFirstPhoto, but none is needed: frames without a photo stay, and one that is no image is none
};

/// Names of Camera::distortion.
extern const std::array<const char*, 6> kDistortionNames;

/// A path as it may have been written under Windows.
std::filesystem::path with_slashes(std::string path);

/// The photo of a frame, suffix optional: in `photos` (may be empty) by its name with as many of its folders as are
/// there, else below one of `folders`, without `photos` also with fewer of its folders, as after a move from another
/// machine (not kView); `\` separates folders where no file has it in its name.  Empty when there is none.
std::filesystem::path find_photo(const std::filesystem::path& photos, const std::vector<std::filesystem::path>& folders,
                                 const std::string& name, PhotoFit fit = PhotoFit::kFirstPhoto);

/// Name of the camera of a photo: its file name without folder, also of Windows, and suffix ("frame.0001" has none).
std::string name_of_photo(const std::filesystem::path& photo);
/// The same with its folders, joined by '_', where several photos have that name.
std::string long_name_of_photo(const std::filesystem::path& photo);
/// The same with its suffix, as in "cam0_shot_png", where several photos differ by nothing else.
std::string full_name_of_photo(const std::filesystem::path& photo);

/// Whether a picture has the shape of the camera, up to one pixel in a side of the smaller of the two.
bool same_shape(const Camera& camera, int width, int height);

/// Size of a photo as it is stored, for files that do not tell it.  A photo that cannot be read is an Error{kInput}, or
/// false when photos are judged one by one.
bool read_photo_size(const std::string& photo, PhotoFit fit, int& width, int& height);

/// Replaces a matrix that is nearly a rotation by the nearest one; false when it is none (error 1e-2, or a mirror).
bool make_rotation(Eigen::Matrix3d& matrix);

/// cam_from_world of a camera whose pose in the world is given with the axes of OpenGL (x right, y up, z back).  A
/// uniform scale of the axes, as of a scaled camera in Blender, is left out.  Returns null, or in words why the matrix
/// is no rigid motion.
const char* cam_from_opengl(const Eigen::Matrix4d& world_from_cam, Eigen::Isometry3d& cam_from_world);

/// What all camera files have in common once their frames are read, in the order of the file.
class CameraCollector {
 public:
  CameraCollector(std::filesystem::path file, PhotoFit fit) : file_(std::move(file)), fit_(fit) {}

  /// A frame with the name that the file gives to its photo; camera.photo is its path on disk or empty, an empty
  /// camera.name becomes the photo's.  Files are named after cameras, so another camera.name loses its slashes and gets
  /// a '_' before a leading dot.
  void add(Camera camera, const std::string& photo_name);

  /// Keeps a photo that several frames found for the frame whose name is most like its path, leaves out frames without
  /// a photo when at least one has one (unless kView), makes names unique, scales the cameras to photos of another size
  /// (unless `sizes_are_of_photos`) and warns about lens distortion (both as PhotoFit says).  Where only the photo
  /// turned by its EXIF orientation has the shape of its camera, that is its size.  Throws Error{kInput} for two frames
  /// of one photo and for a first photo of another shape.
  CameraFile finish(const std::string& format, bool sizes_are_of_photos = false);

 private:
  void give_each_photo_to_one_frame();
  void keep_frames_with_photos();
  void make_names_unique();
  void match_size_of_photos();
  void warn_of_distortion();

  std::filesystem::path file_;
  PhotoFit fit_;
  CameraFile result_;
  std::vector<std::string> names_;
};

}  // namespace pliant
