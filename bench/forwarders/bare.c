/* The floor for a forwarder: one datagram in, four out, nothing looked at. Two kernel calls a datagram
 * and destination, no event loop, no routing. Usage: bare LISTEN_PORT OUT_PORT… */
#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static struct sockaddr_in loopback(const char *port) {
    struct sockaddr_in address;
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons((unsigned short)atoi(port));
    return address;
}

int main(int argc, char **argv) {
    static char buffer[65536];
    int outs[64];
    int count = argc - 2;
    int in = socket(AF_INET, SOCK_DGRAM, 0);
    int size = 4 << 20;
    if (argc < 3 || count > 64 || in < 0) return 2;
    struct sockaddr_in address = loopback(argv[1]);
    setsockopt(in, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
    if (bind(in, (struct sockaddr *)&address, sizeof address)) { perror("bare: bind"); return 1; }
    for (int i = 0; i < count; i++) {
        outs[i] = socket(AF_INET, SOCK_DGRAM, 0);
        address = loopback(argv[i + 2]);
        if (outs[i] < 0 || connect(outs[i], (struct sockaddr *)&address, sizeof address)) { perror("bare: out"); return 1; }
    }
    for (;;) {
        ssize_t length = recv(in, buffer, sizeof buffer, 0);
        if (length <= 0) continue;
        for (int i = 0; i < count; i++) (void)!send(outs[i], buffer, (size_t)length, 0);
    }
}
