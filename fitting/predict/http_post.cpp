#include "fitting/predict/http_post.h"

#include <curl/curl.h>
#include <fmt/format.h>

#include <memory>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

struct Inbox {
  std::string bytes;
  size_t most = 0;
  bool too_large = false;
};

size_t receive(char* data, size_t size, size_t count, void* context) {
  Inbox& inbox = *static_cast<Inbox*>(context);
  inbox.too_large = size * count > inbox.most - inbox.bytes.size();
  if (inbox.too_large) return 0;
  inbox.bytes.append(data, size * count);
  return size * count;
}

bool no_line_breaks(const std::string& text) { return text.find_first_of("\r\n") == std::string::npos; }

}  // namespace

HttpAnswer post(const HttpPost& request) {
  CHECK(request.timeout >= 1e-3);  // curl takes 0 ms for no limit
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(), curl_easy_cleanup);
  CHECK(started == CURLE_OK && curl);
  curl_slist* list = nullptr;
  for (const std::string& header : request.headers) {
    CHECK(no_line_breaks(header));
    list = curl_slist_append(list, header.c_str());
  }
  list = curl_slist_append(list, "Expect:");  // no question before the body
  const std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers(list, curl_slist_free_all);
  Inbox inbox;
  inbox.most = request.max_answer;
  char message[CURL_ERROR_SIZE] = "";
  const auto set = [&](CURLoption option, auto value) {
    CHECK(curl_easy_setopt(curl.get(), option, value) == CURLE_OK);
  };
  set(CURLOPT_URL, request.url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(1000 * request.timeout));
  set(CURLOPT_HTTPHEADER, headers.get());
  set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  set(CURLOPT_POSTFIELDS, request.body.data());
  set(CURLOPT_WRITEFUNCTION, &receive);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&inbox));
  set(CURLOPT_ERRORBUFFER, static_cast<char*>(message));
  const CURLcode code = curl_easy_perform(curl.get());
  HttpAnswer answer;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &answer.status);
  if (inbox.too_large) {
    answer.failure = fmt::format("its answer is longer than {} bytes", request.max_answer);
  } else if (code == CURLE_OPERATION_TIMEDOUT) {
    answer.failure = fmt::format("no whole answer within {:g} s", request.timeout);
  } else if (code != CURLE_OK) {
    answer.failure = message[0] ? message : curl_easy_strerror(code);
  } else {
    answer.body = std::move(inbox.bytes);
  }
  return answer;
}

}  // namespace pliant
