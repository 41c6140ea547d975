#include "station/http/tls_context.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <array>
#include <iterator>

namespace annulus {
namespace {

struct Free {
  void operator()(BIO* bio) const { BIO_free(bio); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

constexpr char kCiphers[] =
    "ECDHE-ECDSA-AES128-GCM-SHA256:ECDHE-ECDSA-AES256-GCM-SHA384:ECDHE-ECDSA-CHACHA20-POLY1305:"
    "ECDHE-RSA-AES128-GCM-SHA256:ECDHE-RSA-AES256-GCM-SHA384:ECDHE-RSA-CHACHA20-POLY1305";
constexpr char kGroups[] = "X25519:P-256:P-384";

tl::unexpected<Error> FailTls(const std::string& seen) {
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return Fail("take the TLS certificate", reason == nullptr ? seen : seen + " (" + reason + ")",
              "give a certificate and its private key, both as PEM");
}

Owned<BIO> Reader(const std::string& text) {
  return Owned<BIO>(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

/// RFC 7301: http/1.1 if it is among the client's, else the handshake ends (so that nobody can pass our answers off as
/// those of another protocol).
int ChooseProtocol(SSL* /*ssl*/, const unsigned char** chosen, unsigned char* chosen_length,
                   const unsigned char* offered, unsigned int offered_length, void* /*argument*/) {
  // What is chosen points into this after the return.
  static constexpr std::array<unsigned char, 9> kHttp11{8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
  unsigned char* out = nullptr;
  const int result = SSL_select_next_proto(&out, chosen_length, kHttp11.data(),
                                           static_cast<unsigned int>(kHttp11.size()), offered, offered_length);
  *chosen = out;
  return result == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

Status UseChain(SSL_CTX& context, const std::string& pem) {
  const Owned<BIO> reader = Reader(pem);
  const Owned<X509> leaf(PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr));
  if (!leaf || SSL_CTX_use_certificate(&context, leaf.get()) != 1) return FailTls("the certificate cannot be read");
  while (true) {
    const Owned<X509> next(PEM_read_bio_X509(reader.get(), nullptr, nullptr, nullptr));
    if (!next) break;
    if (SSL_CTX_add1_chain_cert(&context, next.get()) != 1) return FailTls("its chain cannot be taken");
  }
  ERR_clear_error();  // "no start line": the end of the chain
  return {};
}

Status UseKey(SSL_CTX& context, const std::string& pem) {
  const Owned<BIO> reader = Reader(pem);
  // No password is asked for on the terminal.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  const Owned<EVP_PKEY> key(PEM_read_bio_PrivateKey(reader.get(), nullptr, no_password, nullptr));
  if (!key) return FailTls("the private key cannot be read");
  if (SSL_CTX_use_PrivateKey(&context, key.get()) != 1 || SSL_CTX_check_private_key(&context) != 1) {
    return FailTls("the certificate does not fit the private key");
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<ssl_ctx_st>> MakeTlsContext(const std::string& certificate_pem,
                                                   const std::string& private_key_pem) {
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), &SSL_CTX_free);
  if (!context) return FailTls("OpenSSL gives no context");
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_NO_TICKET |
                                         SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_PRIORITIZE_CHACHA);
  SSL_CTX_set_session_cache_mode(context.get(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(context.get(), 0);
  // A connection that waits holds no buffers.
  SSL_CTX_set_mode(context.get(),
                   SSL_MODE_RELEASE_BUFFERS | SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  const bool set = SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION) == 1 &&
                   SSL_CTX_set_cipher_list(context.get(), kCiphers) == 1 &&
                   SSL_CTX_set1_groups_list(context.get(), kGroups) == 1;
  if (!set) return FailTls("OpenSSL does not know the ciphers");
  SSL_CTX_set_alpn_select_cb(context.get(), &ChooseProtocol, nullptr);
  RETURN_IF_ERROR(UseChain(*context, certificate_pem));
  RETURN_IF_ERROR(UseKey(*context, private_key_pem));
  return context;
}

}  // namespace annulus
