#pragma once

#include <chrono>
#include <string>

#include "station/http/http_head.h"
#include "station/http/http_message.h"

namespace annulus {

/// What becomes of the connection after an answer.
enum class AfterAnswer { kKeepAlive, kClose };

/// Status line and headers of an answer, with the empty line (RFC 9112 §4, §5): those of the handler, then
/// Content-Type, Content-Length, Date and Connection. Content-Length is that of the body also where none is sent
/// (HEAD). `now` is UTC. The handler's mistakes are ours: ENSURE that names are tokens, values have no line ends, none
/// is one of the server's own, and the status is 200 … 599.
[[nodiscard]] std::string AnswerHead(const HttpResponse& response, AfterAnswer after, std::chrono::sys_seconds now);

/// Whether an answer of this status has no body at all (204, 304).
[[nodiscard]] bool IsBodiless(int status);

/// The answer by which the server itself refuses, in the form of docs/console_api.md §1.
[[nodiscard]] HttpResponse ProblemAnswer(const HttpProblem& problem);

}  // namespace annulus
