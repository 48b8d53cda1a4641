// Browsers start no worker for a page that was opened from the disk: there the search runs in a hidden frame in its place.
if (location.protocol === 'file:') {
  window.IFrameWorker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement('iframe');
      frame.hidden = true;
      document.body.appendChild(frame);
      this.inside = frame.contentWindow;
      this.onmessage = null;
      this.inside.postMessage = (data) => {
        const event = new MessageEvent('message', { data });
        this.dispatchEvent(event);
        this.onmessage?.(event);
      };
      const load = (address) =>
        new Promise((done, failed) => {
          const script = this.inside.document.createElement('script');
          Object.assign(script, { src: address, onload: done, onerror: failed });
          this.inside.document.body.appendChild(script);
        });
      this.inside.importScripts = (...addresses) =>
        addresses.reduce((before, address) => before.then(() => load(address)), Promise.resolve());
      this.ready = load(new URL(url, document.baseURI).href);
    }

    postMessage(data) {
      void this.ready.then(() => this.inside.dispatchEvent(new MessageEvent('message', { data })));
    }

    terminate() {
      this.inside.frameElement.remove();
    }
  };
  window.Worker = window.IFrameWorker;
}
