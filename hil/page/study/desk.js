// The connection of a study's page: says who it is, that it is there, and what was said; hands on what it shall show.

const EVERY_MS = 1000;

/** Connects as `who`; `show(view, number)` is called with every view, `lost()` while there is no connection. */
export function connect(who, show, lost) {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  const desk = { socket: null, say: words => desk.socket?.readyState === 1 && desk.socket.send(JSON.stringify(words)) };
  const open = () => {
    const url = new URL("live", location.href);
    url.protocol = "ws:";
    url.hash = "";
    url.search = token ? `?token=${token}` : "";
    const socket = desk.socket = new WebSocket(url);
    socket.onopen = () => desk.say({ who });
    socket.onmessage = message => {
      const { view, shows } = JSON.parse(message.data);
      if (shows) show(shows, view);
    };
    socket.onclose = () => {
      lost();
      setTimeout(open, 300);
    };
  };
  setInterval(() => desk.say({ alive: true }), EVERY_MS);
  open();
  return desk;
}
