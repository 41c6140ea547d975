#include "station/http/request_reader.h"

#include <algorithm>
#include <utility>

namespace annulus {

void RequestReader::Begin() {
  part_ = Part::kHead;
  head_ = {};
  searched_ = 0;
  line_skipped_ = false;
}

RequestReader::Event RequestReader::Next() { return part_ == Part::kHead ? NextHead() : NextBody(); }

std::size_t RequestReader::BodyBytes() const {
  return head_.framing == HttpFraming::kChunked ? head_.body_limit : static_cast<std::size_t>(head_.length);
}

RequestReader::Event RequestReader::Refuse(HttpProblem problem) {
  problem_ = std::move(problem);
  return Event::kRefused;
}

RequestReader::Event RequestReader::NextHead() {
  // RFC 9112 §2.2: an empty line before the request is passed over; one.
  if (!line_skipped_ && received_.starts_with("\r\n")) {
    received_.erase(0, 2);
    line_skipped_ = true;
  }
  if (!line_skipped_ && received_ == "\r") return Event::kMore;
  const std::size_t end = FindHeadEnd(received_, searched_);
  if (end == 0) {
    searched_ = received_.size();
    HttpProblem problem = CheckPartialHead(received_, limits_);
    return problem.status == 0 ? Event::kMore : Refuse(std::move(problem));
  }
  auto head = ParseHead(std::string_view(received_).substr(0, end), limits_);
  if (!head) return Refuse(std::move(head.error()));
  received_.erase(0, end);
  head_ = std::move(*head);
  chunks_ = ChunkedBody(head_.body_limit);
  part_ = Part::kBody;
  return Event::kHead;
}

RequestReader::Event RequestReader::NextBody() {
  std::string& body = head_.request.body;
  if (head_.framing != HttpFraming::kChunked) {
    const std::size_t taken = std::min(static_cast<std::size_t>(head_.length) - body.size(), received_.size());
    body.append(received_, 0, taken);
    received_.erase(0, taken);
    return body.size() == head_.length ? Event::kDone : Event::kMore;
  }
  switch (chunks_.Take(received_, body)) {
    case ChunkedBody::State::kDone:
      return Event::kDone;
    case ChunkedBody::State::kMalformed:
      return Refuse({400, "malformed chunk"});
    case ChunkedBody::State::kTooLarge:
      return Refuse({413, "body too large"});
    case ChunkedBody::State::kMore:
      break;
  }
  return Event::kMore;
}

}  // namespace annulus
