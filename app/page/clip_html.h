#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "app/page/clip_file.h"

namespace pliant {

/// What a clip.html holds.
struct ClipPage {
  ClipFile file;
  std::string poster;  ///< WebP
  std::string video;   ///< mp4, or empty
};

/// Bytes in the file.
struct PageSizes {
  size_t all = 0, until_poster = 0, until_motion = 0;
  std::map<std::string, size_t> sections;
};

/// Writes the page, self-contained: nothing is fetched, and its content security policy forbids it.  Sections are in
/// the order in which the page wants them.  One of more than `most` bytes is a broken invariant and is not written.
PageSizes write_page(const std::filesystem::path& file, const ClipPage& page, SectionPacker& packer,
                     size_t most = SIZE_MAX);

}  // namespace pliant
