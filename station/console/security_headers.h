#pragma once

#include "station/http/http_message.h"

namespace annulus {

/// What kind of answer the headers are for.
enum class AnswerKind {
  kApi,   ///< Never kept by anybody.
  kFile,  ///< Of the page; says itself how long it may be kept.
};

/// Adds the headers that every answer carries (docs/console_api.md §14): content security policy, no sniffing, no
/// referrer, no other origin, no device permissions; for API answers Cache-Control: no-store unless the answer has one;
/// Strict-Transport-Security unless the other side is on this machine (a browser would apply it to all of localhost's
/// ports). OWASP ASVS 5.0 §3.4.
void AddSecurityHeaders(HttpResponse& response, AnswerKind kind, bool loopback);

}  // namespace annulus
