#pragma once

#include <memory>
#include <string>

#include "base/result.h"

// OpenSSL's SSL_CTX.
struct ssl_ctx_st;

namespace annulus {

/// What new connections are shaken hands with: TLS 1.2 (ECDHE with AES-GCM or ChaCha20 only) and 1.3, no renegotiation,
/// no compression, no session tickets, the application protocol http/1.1 or none (whoever insists on another is
/// refused). Shared because connections outlive a renewal. Fails if the texts are no PEM or the certificate does not
/// fit the key.
Result<std::shared_ptr<ssl_ctx_st>> MakeTlsContext(const std::string& certificate_pem,
                                                   const std::string& private_key_pem);

}  // namespace annulus
