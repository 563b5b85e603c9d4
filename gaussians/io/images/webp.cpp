#include "gaussians/io/images/webp.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include "gaussians/base/error.h"

namespace pliant {

ImageU8 decode_webp(std::string_view bytes, size_t most_pixels, const std::string& file) {
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) {
    throw input_error(file, "", "is not a WebP image or its header is damaged", "fetch the file again");
  }
  if (features.has_animation || features.format == 1) {
    throw input_error(
        file, "", features.has_animation ? "is an animation" : "is a lossy WebP image, which changes the values in it",
        "write it as lossless WebP");
  }
  const std::string size = std::to_string(features.width) + " x " + std::to_string(features.height) + " pixels";
  if (static_cast<size_t>(features.width) * static_cast<size_t>(features.height) > most_pixels) {
    throw input_error(
        file, "", "has " + size + ", at most " + std::to_string(most_pixels) + " are justified by the scene's counts",
        "the file is damaged, or meant to exhaust the memory");
  }
  ImageU8 picture(features.width, features.height, 4);
  if (!WebPDecodeRGBAInto(data, bytes.size(), picture.data.data(), picture.data.size(), 4 * picture.width)) {
    throw input_error(file, "", "is a WebP image of " + size + " that cannot be decoded",
                      "the file is truncated or damaged; fetch it again");
  }
  return picture;
}

std::string encode_webp(const ImageU8& image, float quality) {
  CHECK(image.channels == 3);
  uint8_t* bytes = nullptr;
  const size_t size = WebPEncodeRGB(image.data.data(), image.width, image.height, 3 * image.width, quality, &bytes);
  CHECK_MSG(size > 0, "WebP encoder");
  std::string out(reinterpret_cast<const char*>(bytes), size);
  WebPFree(bytes);
  return out;
}

}  // namespace pliant
