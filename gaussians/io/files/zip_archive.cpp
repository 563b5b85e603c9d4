#include "gaussians/io/files/zip_archive.h"

#include <minizip/unzip.h>
#include <minizip/zip.h>

#include "gaussians/base/error.h"
#include "gaussians/io/files/compression.h"
#include "gaussians/io/files/files.h"

namespace pliant {

ZipArchive::ZipArchive(const std::filesystem::path& file) : file_(file.string()) {
  std::error_code failed;
  file_bytes_ = std::filesystem::file_size(file, failed);
  if (failed) throw input_error(file_, "", "cannot be read: " + failed.message(), "check the name");
  zip_ = unzOpen64(file_.c_str());
  if (!zip_)
    throw input_error(file_, "", "is not a zip archive or its directory is damaged",
                      "the file is truncated or damaged; fetch it again");
}

ZipArchive::~ZipArchive() {
  if (zip_) unzClose(zip_);
}

std::vector<std::string> ZipArchive::names() {
  std::vector<std::string> names;
  for (int status = unzGoToFirstFile(zip_); status == UNZ_OK && names.size() < 65536; status = unzGoToNextFile(zip_)) {
    char name[1024];
    unz_file_info64 info;
    if (unzGetCurrentFileInfo64(zip_, &info, name, sizeof name, nullptr, 0, nullptr, 0) != UNZ_OK)
      throw input_error(file_, "", "has a damaged directory", "the archive is damaged; fetch it again");
    if (info.size_filename < sizeof name) names.emplace_back(name, info.size_filename);
  }
  return names;
}

std::string ZipArchive::read(const std::string& entry, uint64_t most) {
  const auto refuse = [&](const std::string& problem) {
    return input_error(file_, entry, problem, "the archive is incomplete or damaged; fetch it again");
  };
  unz_file_info64 info;
  if (unzLocateFile(zip_, entry.c_str(), 1) != UNZ_OK) throw refuse("is missing in the archive");
  if (unzGetCurrentFileInfo64(zip_, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK)
    throw refuse("has a damaged directory entry");
  if (info.flag & 1) throw refuse("is encrypted");
  if (info.uncompressed_size > most) {
    throw refuse("declares " + std::to_string(info.uncompressed_size) + " bytes, at most " + std::to_string(most) +
                 " are justified");
  }
  if (info.compressed_size > file_bytes_) throw refuse("is larger than the archive");
  check_expansion(info.uncompressed_size, file_bytes_, file_, entry);
  if (unzOpenCurrentFile(zip_) != UNZ_OK) throw refuse("has a damaged header or an unknown compression");
  const uint64_t begin = unzGetCurrentFileZStreamPos64(zip_), end = begin + info.compressed_size;
  if (end > file_bytes_) {
    unzCloseCurrentFile(zip_);
    throw refuse("reaches beyond the end of the archive");
  }
  for (const auto& [other_begin, other_end] : taken_) {
    if (begin < other_end && other_begin < end) {
      unzCloseCurrentFile(zip_);
      throw refuse("overlaps another entry");
    }
  }
  taken_.emplace_back(begin, end);
  std::string bytes(info.uncompressed_size, '\0');
  size_t done = 0;
  while (done < bytes.size()) {
    const int count = unzReadCurrentFile(zip_, bytes.data() + done,
                                         static_cast<unsigned>(std::min<size_t>(bytes.size() - done, 1u << 30)));
    if (count <= 0) break;
    done += static_cast<size_t>(count);
  }
  char more;
  const bool longer = done == bytes.size() && unzReadCurrentFile(zip_, &more, 1) > 0;
  const int closed = unzCloseCurrentFile(zip_);
  if (done < bytes.size()) throw refuse("its data end early or are damaged");
  if (longer) throw refuse("contains more than its directory entry states");
  if (closed == UNZ_CRCERROR) throw refuse("its checksum does not match its data");
  return bytes;
}

void write_zip(const std::filesystem::path& file, const std::string& entry, const std::string& bytes) {
  CHECK(bytes.size() <= UINT32_MAX);
  write_atomically(file, [&](const std::filesystem::path& temporary) {
    const zipFile zip = zipOpen64(temporary.c_str(), APPEND_STATUS_CREATE);
    zip_fileinfo info = {};
    info.tmz_date = {0, 0, 0, 1, 0, 1980};
    const bool written =
        zip && zipOpenNewFileInZip64(zip, entry.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, 0, 0, 1) == ZIP_OK &&
        zipWriteInFileInZip(zip, bytes.data(), static_cast<unsigned>(bytes.size())) == ZIP_OK &&
        zipCloseFileInZip(zip) == ZIP_OK;
    const bool closed = zip && zipClose(zip, nullptr) == ZIP_OK;
    if (!written || !closed) throw input_error(file.string(), entry, "cannot be written", "is there room on the disk?");
  });
}

}  // namespace pliant
