class TradingRules:
    STOP_LOSS = -0.05
    TAKE_PROFIT = 0.12
    RSI = dict(low=30, high=70)

    @staticmethod
    def signal(profit, rsi, volume_ratio):
        if profit <= TradingRules.STOP_LOSS or profit >= TradingRules.TAKE_PROFIT:
            return "SELL"
        if rsi < TradingRules.RSI["low"] and volume_ratio > 1.5:
            return "BUY"
        if rsi > TradingRules.RSI["high"]:
            return "SELL"
        return "HOLD"
