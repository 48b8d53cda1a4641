import { describe, expect, it } from 'vitest';
import { commandBar, type Standing } from './command-bar';

describe('commandBar', () => {
  const free: Standing = {
    isRecorded: false,
    isOnline: true,
    isOperator: true,
    hasControl: true,
    isHeldElsewhere: false,
  };

  it('lets an operator in control command, and nobody a recording', () => {
    expect(commandBar(free)).toBeNull();
    expect(commandBar({ ...free, isRecorded: true })).toBe('recording');
    const worst: Standing = {
      isRecorded: true,
      isOnline: false,
      isOperator: false,
      hasControl: false,
      isHeldElsewhere: true,
    };
    expect(commandBar(worst)).toBe('recording');
    expect(commandBar({ ...free, isOnline: false, hasControl: false })).toBe('away');
    expect(commandBar({ ...free, isOperator: false, hasControl: false })).toBe('watching');
    expect(commandBar({ ...free, hasControl: false, isHeldElsewhere: true })).toBe('control');
    expect(commandBar({ ...free, isHeldElsewhere: true })).toBe('held');
  });
});
