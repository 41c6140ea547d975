#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "station/http/chunked_body.h"
#include "station/http/http_head.h"
#include "station/http/http_server.h"

namespace annulus {

/// Takes requests out of the bytes of a connection, one after the other, in whatever pieces they come.
///
///     Append, Next … kHead: the head is there, and its reader decides whether to go on
///     Append, Next … kDone: so is the body. Begin: the next one
///
/// After kRefused nothing but problem() may be called.
class RequestReader {
 public:
  enum class Event { kMore, kHead, kDone, kRefused };

  /// `limits` is borrowed.
  explicit RequestReader(const HttpLimits& limits) : limits_(limits) {}

  /// Forgets the request before; what came after it is kept.
  void Begin();
  void Append(std::string_view bytes) { received_.append(bytes); }
  /// What the bytes so far amount to. kMore: not enough yet.
  [[nodiscard]] Event Next();

  [[nodiscard]] bool empty() const { return received_.empty(); }
  [[nodiscard]] HttpHead& head() { return head_; }
  /// Bytes that the body may take in memory: its length, or with chunks the largest that is allowed.
  [[nodiscard]] std::size_t BodyBytes() const;
  [[nodiscard]] const HttpProblem& problem() const { return problem_; }

 private:
  enum class Part { kHead, kBody };
  Event NextHead();
  Event NextBody();
  Event Refuse(HttpProblem problem);

  const HttpLimits& limits_;
  Part part_ = Part::kHead;
  std::string received_;      ///< Not yet taken.
  std::size_t searched_ = 0;  ///< Of these, in search of the head's end.
  bool line_skipped_ = false;
  HttpHead head_;
  ChunkedBody chunks_{0};
  HttpProblem problem_;
};

}  // namespace annulus
