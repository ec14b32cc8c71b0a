// The line to hil: opened, opened anew when it is lost, and heard.
const AGAIN_MS = [250, 500, 1000, 2000];

// Why there is no line, on a page that has or has not seen a run. Where the server wants a token, a page without one never will.
export function unlinked(run) {
  const lost = run || location.hash || !("token" in document.body.dataset);
  return lost ? "connection lost; trying again" : "no connection: open the address with the token that hil printed";
}

export class Link {
  constructor(hear, stand) {
    Object.assign(this, { hear, stand, tries: 0, closed: false });
    this.open();
  }

  open() {
    // What stands behind the # goes nowhere by itself.
    const token = new URLSearchParams(location.hash.slice(1)).get("token");
    this.socket = new WebSocket(`ws://${location.host}/live${token ? `?token=${token}` : ""}`);
    this.socket.addEventListener("open", () => { this.tries = 0; this.stand(true); });
    this.socket.addEventListener("message", event => this.hear(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      this.stand(false);
      if (!this.closed) setTimeout(() => this.open(), AGAIN_MS[Math.min(this.tries++, AGAIN_MS.length - 1)]);
    });
  }

  send(wish) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(wish));
    return true;
  }

  // Nothing more will come.
  close() {
    this.closed = true;
    this.socket.close();
  }
}
