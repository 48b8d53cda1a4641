import { describe, expect, it } from 'vitest';
import { type ControlStanding, followed, NO_REQUEST } from './control-request';

describe('a request for control', () => {
  it('waits until it is granted, or declined by the one who was asked', () => {
    let request = NO_REQUEST;
    const told: string[] = [];
    const tell = (requestedBy: string | null, change: Partial<ControlStanding> = {}) => {
      const isRequestOurs = requestedBy === 'ground · Luis';
      request = followed(request, { has: false, holder: 'tower · Ana', requestedBy, isRequestOurs, ...change });
      told.push(request.state);
    };
    tell('hill · Eva');
    tell('ground · Luis');
    tell(null);
    tell(null);
    tell('ground · Luis');
    tell(null, { holder: 'ground · Luis', has: true });
    tell('ground · Luis');
    tell(null, { holder: 'hill · Eva' });
    tell('ground · Luis');
    tell(null, { holder: null });
    expect(told.join(' ')).toBe('none waiting declined declined waiting none waiting none waiting none');
  });
});
