#include "segmentation/objects/edit.h"

#include <algorithm>
#include <cstdio>

#include "gaussians/base/error.h"
#include "gaussians/io/files/text.h"
#include "gaussians/io/files/utf8.h"
#include "segmentation/labels/object_names.h"
#include "segmentation/objects/relabel.h"

namespace pliant {
namespace {

std::string described(const Segmentation& s, size_t c) {
  return std::to_string(s.class_id[c]) + " (" + s.class_name[c] + ")";
}

size_t members_of(const Segmentation& s, uint32_t id) {
  return static_cast<size_t>(std::count(s.label.begin(), s.label.end(), id));
}

void set_origin(Segmentation& s, uint32_t id, const std::string& origin) {
  if (s.class_origin.empty()) s.class_origin.assign(s.class_id.size(), "");
  s.class_origin[class_of_id(s, id)] = origin;
}

EditOutcome merge(const ObjectEdit& edit, Segmentation& s) {
  std::vector<uint32_t> ids;
  std::vector<std::string> names;
  for (const std::string& object : edit.objects) {
    const size_t c = class_of_object(s, edit.option(), object);
    if (std::count(ids.begin(), ids.end(), s.class_id[c]))
      throw usage_error(edit.option(), edit.text(), "names object " + described(s, c) + " twice",
                        "give at least two different objects");
    ids.push_back(s.class_id[c]);
    names.push_back(described(s, c));
  }
  EditOutcome outcome{{ids[0]}, 0, ""};
  for (size_t k = 1; k < ids.size(); ++k)
    outcome.merged.emplace_back(ids[k], s.class_name[static_cast<size_t>(class_of_id(s, ids[k]))]);
  std::string others, origin = "merged from " + std::to_string(ids[0]);
  for (size_t k = 1; k < ids.size(); ++k) {
    outcome.gaussians += members_of(s, ids[k]);
    merge_classes(ids[0], ids[k], s);
    others += (k > 1 ? ", " : "") + names[k];
    origin += (k + 1 < ids.size() ? ", " : " and ") + std::to_string(ids[k]);
  }
  set_origin(s, ids[0], origin);
  outcome.sentence = others + " became part of " + names[0];
  return outcome;
}

/// A name that no object has: `name`_2, `name`_3, ...
std::string free_name(const Segmentation& s, const std::string& name) {
  for (int k = 2;; ++k) {
    const std::string candidate = name + "_" + std::to_string(k);
    if (!std::count(s.class_name.begin(), s.class_name.end(), candidate)) return candidate;
  }
}

/// The lists of cameras of `ids` are kept where the picture of the labels shows them.
void keep_cameras_that_show(const std::vector<uint32_t>& ids, const GaussianCloud& cloud,
                            const std::vector<Camera>& cameras, Segmentation& s) {
  if (s.class_cameras.empty()) return;
  const std::vector<int> candidates = s.class_cameras[class_of_id(s, ids[0])];
  std::vector<std::vector<int>> shown(ids.size());
  for (int camera : candidates) {
    if (camera < 0 || camera >= static_cast<int>(cameras.size())) continue;
    const IdImage picture = render_ids(s, cloud, cameras[camera]);
    for (size_t k = 0; k < ids.size(); ++k)
      if (std::count(picture.data.begin(), picture.data.end(), ids[k])) shown[k].push_back(camera);
  }
  for (size_t k = 0; k < ids.size(); ++k) s.class_cameras[class_of_id(s, ids[k])] = std::move(shown[k]);
}

EditOutcome split(const SplitOptions& options, const ObjectEdit& edit, const GaussianCloud& cloud,
                  const std::vector<Camera>& cameras, Segmentation& s) {
  const size_t c = class_of_object(s, edit.option(), edit.objects[0]);
  const uint32_t id = s.class_id[c];
  const std::string before = described(s, c), name = s.class_name[c];
  std::vector<uint8_t> member(s.label.size());
  for (size_t p = 0; p < member.size(); ++p) member[p] = s.label[p] == id;
  const SplitResult parts = split_object(options, cloud, member);
  if (parts.parts < 2)
    throw usage_error(edit.option(), edit.objects[0],
                      "has " + std::to_string(members_of(s, id)) + " Gaussians, which cannot be separated",
                      "choose a larger object");
  EditOutcome outcome{{id}, 0, ""};
  std::string list;
  for (int k = 1; k < parts.parts; ++k) {
    for (size_t p = 0; p < member.size(); ++p) {
      member[p] = parts.part[p] == k;
      outcome.gaussians += member[p];
    }
    const uint32_t fresh = unused_id(s);
    split_class(id, fresh, free_name(s, name), member, s);
    set_origin(s, fresh, "split from " + std::to_string(id));
    outcome.ids.push_back(fresh);
    list += (k > 1 ? ", " : "") + described(s, static_cast<size_t>(class_of_id(s, fresh)));
  }
  keep_cameras_that_show(outcome.ids, cloud, cameras, s);
  char share[32];
  std::snprintf(share, sizeof share, "%.1f %%", 100 * parts.cut_share);
  outcome.sentence = before + " was split into " + std::to_string(parts.parts) + " objects; new: " + list +
                     (parts.cut ? "; it is connected and was cut by color and distance, through at most " +
                                      std::string(share) + " of the connections of a part"
                                : "");
  return outcome;
}

EditOutcome drop(const ObjectEdit& edit, const GaussianCloud& cloud, Segmentation& s) {
  const size_t c = class_of_object(s, edit.option(), edit.objects[0]);
  const uint32_t id = s.class_id[c];
  const std::string before = described(s, c);
  const std::vector<uint32_t> label = s.label;
  const size_t gaussians = drop_class(id, cloud.position, s);
  std::string list;
  for (size_t to = 0; to < s.class_id.size(); ++to) {
    size_t count = 0;
    for (size_t p = 0; p < label.size(); ++p) count += label[p] == id && s.label[p] == s.class_id[to];
    if (count > 0) list += (list.empty() ? ": " : ", ") + std::to_string(count) + " that of " + described(s, to);
  }
  return {{},
          gaussians,
          before + " was removed: its " + std::to_string(gaussians) +
              " Gaussians were given the label of their surroundings" + list};
}

/// Throws Error{kUsage} where an object cannot have the new name.
void check_new_name(const ObjectEdit& edit) {
  const auto refuse = [&](const std::string& problem, const std::string& remedy) {
    return usage_error(edit.option(), edit.text(), problem, remedy);
  };
  if (edit.name.find_first_not_of("0123456789") == std::string::npos)
    throw refuse("is a name that could be an ID", "give a name with a letter in it");
  if (as_utf8(edit.name) != edit.name) throw refuse("is a name that is not UTF-8", "write it in UTF-8");
  if (const size_t characters = character_count(edit.name); characters > kLongestName)
    throw refuse("is a name of " + std::to_string(characters) + " characters",
                 "give one of at most " + std::to_string(kLongestName));
  for (char c : edit.name)
    if (static_cast<unsigned char>(c) < 32 || c == ',')
      throw refuse("is a name with a comma or an unprintable character", "leave it out");
}

EditOutcome rename(const ObjectEdit& edit, Segmentation& s) {
  check_new_name(edit);
  const size_t c = class_of_object(s, edit.option(), edit.objects[0]);
  for (size_t other = 0; other < s.class_name.size(); ++other)
    if (other != c && s.class_name[other] == edit.name)
      throw usage_error(edit.option(), edit.name, "is the name of object " + std::to_string(s.class_id[other]),
                        "give another name, or merge them with --merge");
  const std::string before = described(s, c), old_name = s.class_name[c];
  s.class_name[c] = edit.name;
  return {{s.class_id[c]}, 0, before + " was renamed to " + edit.name, old_name};
}

}  // namespace

const char* ObjectEdit::option() const {
  switch (kind) {
    case Kind::kMerge:
      return "--merge";
    case Kind::kSplit:
      return "--split";
    case Kind::kDrop:
      return "--drop";
    default:
      return "--name";
  }
}

std::string ObjectEdit::text() const {
  std::string text;
  for (const std::string& object : objects) text += (text.empty() ? "" : ",") + object;
  return kind == Kind::kName ? text + "=" + name : text;
}

ObjectEdit ObjectEdit::parse(Kind kind, const std::string& text) {
  ObjectEdit edit;
  edit.kind = kind;
  const auto refuse = [&](const std::string& problem, const std::string& remedy) {
    return usage_error(edit.option(), text, problem, remedy);
  };
  if (kind == Kind::kName) {
    const size_t at = text.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == text.size())
      throw refuse("is not an object and a name", "give ID=NAME, for example 3=vase");
    edit.objects = {text.substr(0, at)};
    edit.name = text.substr(at + 1);
    check_new_name(edit);
    return edit;
  }
  edit.objects = kind == Kind::kMerge ? split(text, ',') : std::vector<std::string>{text};
  for (const std::string& object : edit.objects)
    if (object.empty()) throw refuse("has an empty entry", "give ids or names");
  if (kind == Kind::kMerge && edit.objects.size() < 2)
    throw refuse("is one object", "give two or more, for example 3,7");
  return edit;
}

EditOutcome apply_edit(const SplitOptions& options, const ObjectEdit& edit, const GaussianCloud& cloud,
                       const std::vector<Camera>& cameras, Segmentation& segmentation) {
  CHECK(segmentation.label.size() == cloud.size());
  switch (edit.kind) {
    case ObjectEdit::Kind::kMerge:
      return merge(edit, segmentation);
    case ObjectEdit::Kind::kSplit:
      return split(options, edit, cloud, cameras, segmentation);
    case ObjectEdit::Kind::kDrop:
      return drop(edit, cloud, segmentation);
    default:
      return rename(edit, segmentation);
  }
}

}  // namespace pliant
