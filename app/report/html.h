#pragma once

#include <string>

#include "app/run/run_directory.h"

namespace pliant {

/// A page up to the begin of its body.
std::string html_begin(const std::string& title);
std::string html_escaped(const std::string& text);
/// A PNG picture, or an mp4 video, of the run directory within the page, with a caption; empty when there is no such
/// file.
std::string html_picture(const RunDirectory& run, const std::string& file, const std::string& caption);
std::string html_video(const RunDirectory& run, const std::string& file, const std::string& caption);

/// Puts `text` in the place of the first `mark` of a template, which has one.
void fill_mark(std::string& page, const std::string& mark, const std::string& text);
/// Text of a script element, in which nothing may look like its end.
std::string in_script(std::string text);
/// The same of JSON, in which nothing looks like markup of any kind; bytes that are not UTF-8 become U+FFFD.
std::string json_in_script(const nlohmann::json& value);

}  // namespace pliant
