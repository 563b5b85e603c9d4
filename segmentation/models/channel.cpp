#include "segmentation/models/channel.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

#include "gaussians/io/files/byte_reader.h"

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point deadline_in(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(seconds, 1e8)));
}

/// Waits until `descriptor` can be read or written; false after the deadline.
bool wait_for(int descriptor, short events, Clock::time_point deadline) {
  for (;;) {
    const double left = std::chrono::duration<double, std::milli>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd entry{descriptor, events, 0};
    const int ready = poll(&entry, 1, static_cast<int>(std::min(std::ceil(left), 1e9)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

template <class T>
void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
void put_array(std::string& bytes, const T* data, size_t count) {
  put(bytes, static_cast<uint64_t>(count));
  bytes.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

template <class Sequence>
void take_array(ByteReader& reader, Sequence& values) {
  using T = typename Sequence::value_type;
  const auto count = reader.take<uint64_t>("count");
  reader.expect(count, sizeof(T), "count");
  values.resize(count);
  if (count > 0) std::memcpy(values.data(), reader.take_bytes(count * sizeof(T), "data").data(), count * sizeof(T));
}

std::string packed(const Message& message) {
  std::string bytes;
  size_t room = 256 + message.text.size();
  for (const Tensor& tensor : message.tensors)
    room += 128 + tensor.values.size() * sizeof(float) + tensor.integers.size() * sizeof(int64_t);
  bytes.reserve(room);
  put(bytes, message.kind);
  put(bytes, message.threads);
  put(bytes, message.memory);
  put_array(bytes, message.text.data(), message.text.size());
  put(bytes, static_cast<uint64_t>(message.names.size()));
  for (const std::string& name : message.names) put_array(bytes, name.data(), name.size());
  put(bytes, static_cast<uint64_t>(message.tensors.size()));
  for (const Tensor& tensor : message.tensors) {
    put(bytes, tensor.type);
    put_array(bytes, tensor.shape.data(), tensor.shape.size());
    put_array(bytes, tensor.values.data(), tensor.values.size());
    put_array(bytes, tensor.integers.data(), tensor.integers.size());
  }
  return bytes;
}

Message unpacked(const std::string& bytes) {
  ByteReader reader(bytes, "message");
  Message message;
  message.kind = reader.take<Message::Kind>("kind");
  message.threads = reader.take<uint64_t>("threads");
  message.memory = reader.take<uint64_t>("memory");
  take_array(reader, message.text);
  const auto names = reader.take<uint64_t>("names");
  reader.expect(names, 8, "names");
  message.names.resize(names);
  for (std::string& name : message.names) take_array(reader, name);
  const auto tensors = reader.take<uint64_t>("tensors");
  reader.expect(tensors, 25, "tensors");
  message.tensors.resize(tensors);
  for (Tensor& tensor : message.tensors) {
    tensor.type = reader.take<Tensor::Type>("type");
    if (tensor.type > Tensor::Type::kOther) tensor.type = Tensor::Type::kOther;
    take_array(reader, tensor.shape);
    take_array(reader, tensor.values);
    take_array(reader, tensor.integers);
  }
  return message;
}

}  // namespace

Channel::~Channel() { close(descriptor_); }

bool Channel::send(const Message& message, double seconds) {
  const std::string body = packed(message);
  const uint64_t length = body.size();
  const Clock::time_point deadline = deadline_in(seconds);
  const auto write_all = [&](const char* data, uint64_t left) {
    while (left > 0) {
      if (!wait_for(descriptor_, POLLOUT, deadline)) return false;
      const ssize_t sent = ::send(descriptor_, data, left, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EINTR && errno != EAGAIN) return false;
      if (sent > 0) {
        data += sent;
        left -= sent;
      }
    }
    return true;
  };
  return write_all(reinterpret_cast<const char*>(&length), sizeof length) && write_all(body.data(), length);
}

Channel::Received Channel::receive(Message& message, double seconds, uint64_t most) {
  const Clock::time_point deadline = deadline_in(seconds);
  const auto read_all = [&](char* data, uint64_t left) {
    while (left > 0) {
      if (!wait_for(descriptor_, POLLIN, deadline)) return Received::kTooLate;
      const ssize_t got = ::recv(descriptor_, data, left, MSG_DONTWAIT);
      if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) return Received::kClosed;
      if (got > 0) {
        data += got;
        left -= got;
      }
    }
    return Received::kMessage;
  };
  uint64_t length = 0;
  if (const Received head = read_all(reinterpret_cast<char*>(&length), sizeof length); head != Received::kMessage)
    return head;
  if (length > most) return Received::kTooBig;
  std::string body(length, '\0');
  if (const Received rest = read_all(body.data(), length); rest != Received::kMessage) return rest;
  message = unpacked(body);
  return Received::kMessage;
}

}  // namespace pliant
